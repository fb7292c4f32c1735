"""TSurf texts of one surface in many dialects, and files that cannot be read."""

from __future__ import annotations

import re

HEAD = "GOCAD TSurf 1\nHEADER {\nname:A\n}\n"
MESH = "TFACE\nVRTX 1 0 0 1\nVRTX 2 1 0 2\nVRTX 3 0 1 3\nVRTX 4 1 1 4\nTRGL 1 2 3\nTRGL 2 4 3\nEND\n"


def frame(sign: str) -> str:
    return (
        'GOCAD_ORIGINAL_COORDINATE_SYSTEM\nNAME Default\nAXIS_NAME "X" "Y" "Z"\nAXIS_UNIT "m" "m" "m"\n'
        f"ZPOSITIVE {sign}\nEND_ORIGINAL_COORDINATE_SYSTEM\n"
    )


PROPERTIES = (
    "PROPERTIES a b\nPROP_LEGAL_RANGES **none** **none** **none** **none**\nNO_DATA_VALUES -99999 -99999\n"
    "PROPERTY_CLASSES a b\nPROPERTY_KINDS unknown unknown\n"
    "PROPERTY_SUBCLASSES QUANTITY Float QUANTITY Float\nESIZES 1 1\nUNITS none none\n"
    "PROPERTY_CLASS_HEADER a {\nname: not the surface's\nkind: Z\n}\n"
)

#: All hold the surface 'A' of two triangles with elevations 1 to 4.
SAME = {
    "plain": HEAD + MESH,
    "one-line header": "GOCAD TSurf 1\nHEADER { name: A }\n" + MESH,
    "one-line header, more keys": "GOCAD TSurf 1\nHEADER {name:A *visible:true *solid*color: 1 0 0 1}\n"
    + MESH,
    "quoted name": 'GOCAD TSurf 1\nHEADER {\n*solid*color: 1 1 1 1\nname: "A"\n}\n' + MESH,
    "name of the feature": "GOCAD TSurf 1\nHEADER {\n}\nGEOLOGICAL_FEATURE A\nGEOLOGICAL_TYPE fault\n" + MESH,
    "elevation stated": HEAD + frame("Elevation") + MESH,
    "depth stated": HEAD
    + frame("Depth")
    + MESH.replace("0 0 1\n", "0 0 -1\n")
    .replace("1 0 2\n", "1 0 -2\n")
    .replace("VRTX 3 0 1 3", "VRTX 3 0 1 -3")
    .replace("1 1 4", "1 1 -4"),
    "properties": HEAD + PROPERTIES + re.sub(r"VRTX(.*)", r"PVRTX\1 7 8", MESH),
    "Windows line ends": (HEAD + MESH).replace("\n", "\r\n"),
    "ids from zero": HEAD
    + "TFACE\nVRTX 0 0 0 1\nVRTX 1 1 0 2\nVRTX 2 0 1 3\nVRTX 3 1 1 4\nTRGL 0 1 2\nTRGL 1 3 2\nEND\n",
    "ids with gaps, unordered": HEAD
    + "TFACE\nVRTX 90 0 0 1\nVRTX 7 1 0 2\nVRTX 50 0 1 3\nVRTX 8 1 1 4\nTRGL 90 7 50\nTRGL 7 8 50\nEND\n",
    "two parts that share vertices by atoms": HEAD
    + "TFACE\nVRTX 1 0 0 1\nVRTX 2 1 0 2\nVRTX 3 0 1 3\nTRGL 1 2 3\n"
    + "TFACE\nATOM 4 2\nPATOM 5 3 0.5\nVRTX 6 1 1 4\nTRGL 4 6 5\nBSTONE 1\nBORDER 7 1 2\nEND\n",
    "exponents": HEAD + MESH.replace("1 0 2\n", "1.0E0 0.0 2.0e+00\n"),
}

#: What cannot be read, and words of the sentence that says so.
BROKEN = {
    "letters for a number": (HEAD + MESH.replace("1 0 2\n", "abc 0 2\n"), ("line 7", "'abc'")),
    "letters for an id": (HEAD + MESH.replace("TRGL 2 4 3", "TRGL 2 x 3"), ("line 11", "'x'")),
    "a fraction for an id": (HEAD + MESH.replace("TRGL 2 4 3", "TRGL 2 4.5 3"), ("line 11", "'4.5'")),
    "a vertex cut short": (HEAD + MESH.replace("1 0 2\n", "1 0\n"), ("line 7", "cut short")),
    "a triangle cut short": (HEAD + MESH.replace("TRGL 2 4 3", "TRGL 2 4"), ("line 11", "cut short")),
    "no END": (HEAD + MESH.replace("END\n", ""), ("cut short",)),
    "cut in the middle": ((HEAD + MESH)[:75], ("cut short",)),
    "an object inside another": (HEAD + MESH.replace("END\n", "") + HEAD + MESH, ("line 12", "END")),
    "no triangle": (HEAD + "TFACE\nVRTX 1 0 0 0\nEND\n", ("no triangle",)),
    "no surface": ("GOCAD PLine 1\nHEADER {\nname:A\n}\nILINE\nVRTX 1 0 0 0\nEND\n", ("PLine", "no TSurf")),
    "another format": ("solid a\nfacet normal 0 0 1\n", ("line 1", "GOCAD TSurf")),
    "an unknown sign": (HEAD + frame("Sideways") + MESH, ("line 9", "Sideways")),
    "an id twice": (HEAD + MESH.replace("VRTX 4 1", "VRTX 1 1"), ("line 9", "line 6")),
    "an id beyond 64 bits": (HEAD + MESH.replace("TRGL 2 4 3", f"TRGL 2 {10**30} 3"), ("line 11",)),
    "empty": ("", ("empty",)),
    "blank": ("\n \n\t\n", ("empty",)),
    "zero bytes": (HEAD + "\0\0\0" + MESH, ("not a text file",)),
}
