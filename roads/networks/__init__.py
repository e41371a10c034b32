"""Networks of lanes: links, routes, and roads put together along them."""
