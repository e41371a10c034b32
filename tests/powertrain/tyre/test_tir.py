"""Reading `.tir` files: what is accepted, what is refused and with which words."""

from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from powertrain import VehicleError
from powertrain.tyre import MfTyre, read_tir
from powertrain.tyre.tir import parse_tir

from .conftest import BOOK, HERE, SAMPLE

GOOD = (HERE / "mf52_sample.tir").read_text(encoding="utf-8")
Writer = Callable[[str | bytes], Path]


@pytest.fixture
def write(tmp_path: Path) -> Writer:
    def write(content: str | bytes) -> Path:
        path = tmp_path / "tyre.tir"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def changed(old: str, new: str) -> str:
    assert GOOD.count(old) == 1, old
    return GOOD.replace(old, new)


MALFORMED = {
    "no equals sign": (changed("PCX1 = 1.61", "PCX1 1.61"), r"line 39: found 'PCX1 1\.61', expected \[SECTION\], KEY = value or a comment"),
    "no number": (changed("PCX1 = 1.61", "PCX1 = 1.6l"), r"line 39: found 'PCX1 = 1\.6l', expected a finite number for PCX1"),
    "no value": (changed("PCX1 = 1.61", "PCX1 = $ 1.61"), r"line 39: found 'PCX1 =', expected a finite number for PCX1"),
    "not a number": (changed("PCX1 = 1.61", "PCX1 = nan"), r"line 39: found 'PCX1 = nan', expected a finite number for PCX1"),
    "infinite": (changed("PCX1 = 1.61", "PCX1 = 1e999"), r"line 39: found 'PCX1 = 1e999', expected a finite number for PCX1"),
    "number in quotes": (changed("PCX1 = 1.61", "PCX1 = '1.61'"), r"line 39: PCX1 is '1\.61', expected a number"),
    "two values": (changed("PCX1 = 1.61", "PCX1 = 1.61 1.62"), r"line 39: found 'PCX1 = 1\.61 1\.62', expected a finite number"),
    "open quote": (changed("'LEFT'", "'LEFT"), r"line 11: found \"TYRESIDE = 'LEFT\", expected text between a pair of single quotes"),
    "bad key": (changed("PCX1 = 1.61", "P CX1 = 1.61"), r"line 39: found 'P CX1 = 1\.61', expected a key of letters"),
    "open section": (changed("[LATERAL_COEFFICIENTS]", "[LATERAL_COEFFICIENTS"), r"line 63: found '\[LATERAL_COEFFICIENTS', expected a section name"),
    "empty section": (changed("[LATERAL_COEFFICIENTS]", "[ ]"), r"line 63: found '\[ \]', expected a section name in brackets"),
    "key before section": ("PCX1 = 1\n" + GOOD, r"line 1: found 'PCX1 = 1', expected a \[SECTION\] before the first key"),
    "key twice": (changed("PDX1 = 1.14", "PCX1 = 1.14"), r"line 40: PCX1 again, expected once in \[LONGITUDINAL_COEFFICIENTS\], first in line 39"),
    "key in two sections": (GOOD + "[EXTRA]\nPCX1 = 1\n", r"PCX1 again in \[EXTRA\], expected once, first in line 39"),
    "missing coefficient": (changed("PKY2 = 1.83\n", ""), r"key PKY2 is missing, expected it among the coefficients"),
    "missing load": (changed("FNOMIN = 4500\n", ""), r"key FNOMIN is missing"),
    "missing model": (changed("FITTYP = 52\n", ""), r"key FITTYP of \[MODEL\] is missing, expected one of 6, 21, 52, 60, 61, 62"),
    "other model": (changed("FITTYP = 52", "FITTYP = 5"), r"line 9: FITTYP is 5\.0, expected one of 6, 21, 52, 60, 61, 62"),
    "model in quotes": (changed("FITTYP = 52", "FITTYP = 'MF'"), r"line 9: FITTYP is 'MF', expected one of"),
    "millimetres": (changed("'meter'", "'mm'"), r"line 3: unit of LENGTH is 'mm', expected SI, 'meter'"),
    "degrees": (changed("'radians'", "'degrees'"), r"line 5: unit of ANGLE is 'degrees', expected SI, 'radians'"),
    "side": (changed("'LEFT'", "'FRONT'"), r"line 11: TYRESIDE is 'FRONT', expected 'LEFT', 'RIGHT' or 'SYMMETRIC'"),
    "zero load": (changed("FNOMIN = 4500", "FNOMIN = 0"), r"line 15: FNOMIN is 0, expected more than 0"),
    "load in kN": (changed("FNOMIN = 4500", "FNOMIN = 4.5"), r"line 15: FNOMIN is 4\.5, expected 50 to 200000 N"),
    "huge": (changed("PKY1 = -21.3", "PKY1 = -1e300"), r"PKY1 is -1e\+300, expected at most 1e\+09"),
    "negative friction scale": (changed("LMUX = 0.95", "LMUX = -1"), r"LMUX is -1, expected more than 0"),
    "zero stiffness": (changed("PKY1 = -21.3", "PKY1 = 0"), r"PKY1 is 0, expected a number other than 0"),
    "turned range": (changed("ALPMAX =  0.4", "ALPMAX = -0.5"), r"line 25: ALPMIN is -0\.4 and ALPMAX is -0\.5, expected an increasing pair"),
    "binary": (b"[UNITS]\n\0\0", r"found binary data or UTF-16, expected a text file"),
    "UTF-16": (GOOD.encode("utf-16"), r"found binary data or UTF-16, expected a text file"),
    "empty": ("", r"key FITTYP of \[MODEL\] is missing"),
    "too long": (b"!" * 1_000_001, r"found 1000001 bytes, expected a text file"),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_a_malformed_file_is_refused_in_one_line_with_file_place_found_and_expected(case: str, write: Writer):
    content, words = MALFORMED[case]
    path = write(content)
    with pytest.raises(VehicleError, match=words) as caught:
        read_tir(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message


def test_a_missing_file_or_name_is_refused_with_what_there_is(tmp_path: Path):
    with pytest.raises(VehicleError, match="no such file$"):
        read_tir(tmp_path / "none.tir")
    with pytest.raises(VehicleError, match=r"nonesuch: no such file and no shipped tyre, expected a \.tir file or one of car205_60r15$"):
        read_tir("nonesuch")
    tmp_path.with_suffix(".tir").mkdir()
    with pytest.raises(VehicleError, match="cannot be read"):
        read_tir(tmp_path.with_suffix(".tir"))


@given(text=st.text(max_size=300))
def test_no_text_raises_anything_but_the_one_exception(text: str, tmp_path_factory: pytest.TempPathFactory):
    path = tmp_path_factory.getbasetemp() / "any.tir"
    path.write_bytes(text.encode("utf-8", errors="surrogatepass"))
    with pytest.raises(VehicleError):
        read_tir(path)


@pytest.mark.parametrize("ends", ["\r\n", "\r"])
def test_line_ends_encodings_and_a_byte_order_mark_are_without_effect(ends: str, write: Writer):
    text = "! Reifen für Versuche\n" + GOOD
    for encoding in ("utf-8", "utf-8-sig", "latin-1"):
        tyre = read_tir(write(text.replace("\n", ends).encode(encoding)))
        assert tyre.coefficients == SAMPLE.coefficients


def test_a_byte_that_only_unicode_calls_a_line_end_does_not_end_a_comment(write: Writer):
    """0x85 is the dots of Windows-1252."""
    assert read_tir(write(b"! and so on \x85 = dots\n" + GOOD.encode())).coefficients == SAMPLE.coefficients


def test_comments_case_spaces_and_fortran_exponents_are_understood(write: Writer):
    text = changed("PCX1 = 1.61", "  pcx1=+.161D+01   $ shape = 2").replace("'LEFT'", "'LEFT' ! not '$'")
    text = changed_in(text, "[VERTICAL]", " [Vertical]  $ load")
    assert read_tir(write(text)).coefficients == SAMPLE.coefficients
    assert SAMPLE.coefficients.VERTICAL_STIFFNESS == 2.1e5
    sections = parse_tir(write("[A]\nTEXT = 'price $5!' $ dear\nWORD = bare\n"))
    assert sections["A"]["TEXT"].value == "price $5!"
    assert sections["A"]["WORD"].value == "bare"
    assert sections["A"]["TEXT"].line == 2


def changed_in(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


def test_tables_of_adams_files_are_passed_over_but_text_among_them_is_not(write: Writer):
    table = "[SHAPE]\n{radial width}\n 1.0 0.0\n 1.0 0.4\n"
    assert read_tir(write(GOOD + table)).coefficients == SAMPLE.coefficients
    with pytest.raises(VehicleError, match=r"found '0\.9 wide'"):
        read_tir(write(GOOD + table + "0.9 wide\n"))


@pytest.mark.parametrize(("fittyp", "version"), [(6, "5.2"), (21, "5.2"), (52, "5.2"), (60, "6.1"), (61, "6.1"), (62, "6.1")])
def test_fittyp_chooses_the_equations(fittyp: int, version: str, write: Writer):
    assert read_tir(write(changed("FITTYP = 52", f"FITTYP = {fittyp}"))).version == version


def test_an_adams_file_without_fittyp_is_52(write: Writer):
    assert read_tir(write(changed("FITTYP = 52", "PROPERTY_FILE_FORMAT = 'PAC2002'"))).version == "5.2"


def test_what_a_file_leaves_out_is_zero_or_one_for_scaling_factors():
    p = BOOK.coefficients
    assert p.PEX4 == p.REX1 == p.QDZ10 == p.PPX1 == 0.0
    assert p.LFZO == p.LMUX == p.LKZC == 1.0
    assert p.PKY4 == 2.0
    assert (SAMPLE.side, BOOK.side) == ("left", "symmetric")


def test_the_shipped_tyre_has_the_numbers_of_the_book():
    """A sample of table A3.1, and what the book's plots of such a tyre show: peaks about 1.2 and 1, cornering stiffness 10 to 14 per rad of load."""
    p = BOOK.coefficients
    assert (p.PCX1, p.PKX1, p.PKY1, p.PEY4, p.QBZ9, p.SSZ3, p.RVY4) == (1.685, 21.51, -14.95, -4.787, 18.47, 0.731, 35.44)
    slip = np.linspace(0.0, 0.4, 401)
    assert 1.15 < BOOK.forces(slip, 0.0, 4000.0).longitudinal.max() / 4000.0 < 1.25
    assert 0.85 < BOOK.forces(0.0, slip, 4000.0).lateral.max() / 4000.0 < 1.1
    assert 10.0 < BOOK.cornering_stiffness(4000.0) / 4000.0 < 14.0
    assert BOOK.check() == []


def test_clipping_holds_the_inputs_within_the_files_ranges():
    at_edge = SAMPLE.forces(0.6, 0.4, 10e3, 0.15)
    assert SAMPLE.forces(2.0, 1.2, 30e3, 0.5, clip=True) == at_edge
    assert SAMPLE.forces(-2.0, -1.2, 30e3, -0.5, clip=True) == SAMPLE.forces(-0.6, -0.4, 10e3, -0.15)
    assert SAMPLE.forces(2.0, 1.2, 30e3, 0.5) != at_edge
    inside = (0.1, -0.2, 4000.0, 0.05)
    assert SAMPLE.forces(*inside, clip=True) == SAMPLE.forces(*inside)


def test_below_the_least_load_a_clipped_tyre_falls_to_zero_in_proportion():
    least, half = SAMPLE.forces(0.1, 0.1, 300.0, clip=True), SAMPLE.forces(0.1, 0.1, 150.0, clip=True)
    assert np.allclose(half, 0.5 * np.array(least))
    assert np.all(np.array(SAMPLE.forces(0.1, 0.1, 0.0, clip=True)) == 0.0)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("PDX2", -2.0, "longitudinal peak D_x is -.* at a load of .* N, expected more than 0"),
        ("PEX1", 1.5, "longitudinal curvature E_x is .*, expected at most 1"),
        ("PEY1", 1.2, "lateral curvature E_y is .*, expected at most 1"),
        ("PKY1", 21.3, "cornering stiffness K_y is .*, expected negative in the file's signs"),
        ("PKX2", -30.0, "longitudinal slip stiffness K_x"),
        ("QBZ1", -9.0, "trail slope B_t"),
        ("QDZ1", -0.1, "trail peak D_t"),
        ("QEZ1", 1.4, "trail curvature E_t"),
        ("REX1", 1.4, "combined curvature E_x,alpha"),
        ("REY1", 1.4, "combined curvature E_y,kappa"),
        ("RCX1", 0.0, "friction circle is not kept"),
        ("QCZ1", 0.0, "pneumatic trail does not fall"),
        ("PDY1", 9.0, "lateral friction is .*, expected less than 5"),
        ("LMUV", 0.1, "decay of friction with sliding speed is not modelled"),
        ("VERTICAL_STIFFNESS", 0.0, "rolling radius is taken as the unloaded radius"),
    ],
)
def test_check_names_what_is_out_of_physics(key: str, value: float, words: str):
    tyre = msgspec.structs.replace(SAMPLE, coefficients=msgspec.structs.replace(SAMPLE.coefficients, **{key: value}))
    assert SAMPLE.check() == []
    found = tyre.check()
    assert any(_matches(words, line) for line in found), found


def _matches(words: str, line: str) -> bool:
    import re

    return re.search(words, line) is not None


def test_check_names_coefficients_that_no_equation_uses(write: Writer):
    tyre = read_tir(write(changed("PTX3 = 0.2", "PTX3 = 0.2\nPCX9 = 1")))
    assert tyre.check() == ["keys that no equation here uses: PCX9"]


def test_relaxation_without_coefficients_is_refused_not_guessed():
    bare = msgspec.structs.replace(BOOK.coefficients, LATERAL_STIFFNESS=0.0)
    tyre = MfTyre(name="bare.tir", version="6.1", coefficients=bare)
    with pytest.raises(VehicleError, match=r"^bare\.tir: LONGITUDINAL_STIFFNESS or LATERAL_STIFFNESS is missing, expected both"):
        tyre.relaxation(4000.0)
