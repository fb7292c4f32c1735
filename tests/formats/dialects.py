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


DEPTHS = re.sub(r"^(VRTX.*) (\d)$", r"\1 -\2", MESH, flags=re.MULTILINE)


def model3d(surfaces: str, sign: str = "Elevation") -> str:
    """A Model3d that lists the surface A as a fault in two parts, and the objects that follow it."""
    key = "  0 0 1\n  1 0 2\n  0 1 3\n"
    listed = f"TSURF A\nTFACE 1 fault A\n{key}TFACE 2 fault A\n{key}REGION 3 Universe\n  +1 -2 0\n"
    return f"GOCAD Model3d 1\nHEADER {{\nname:M\n}}\n{frame(sign)}{listed}LAYER L\n  3 0\nEND\n{surfaces}"


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
    "depth stated": HEAD + frame("Depth") + DEPTHS,
    "properties": HEAD + PROPERTIES + re.sub(r"VRTX(.*)", r"PVRTX\1 7 8", MESH),
    "Windows line ends": (HEAD + MESH).replace("\n", "\r\n"),
    "ids from zero": HEAD
    + "TFACE\nVRTX 0 0 0 1\nVRTX 1 1 0 2\nVRTX 2 0 1 3\nVRTX 3 1 1 4\nTRGL 0 1 2\nTRGL 1 3 2\nEND\n",
    "ids with gaps, unordered": HEAD
    + "TFACE\nVRTX 90 0 0 1\nVRTX 7 1 0 2\nVRTX 50 0 1 3\nVRTX 8 1 1 4\nTRGL 90 7 50\nTRGL 7 8 50\nEND\n",
    "two parts that share vertices by atoms": HEAD
    + "TFACE\nVRTX 1 0 0 1\nVRTX 2 1 0 2\nVRTX 3 0 1 3\nTRGL 1 2 3\n"
    + "TFACE\nATOM 4 2\nPATOM 5 3 0.5\nVRTX 6 1 1 4\nTRGL 4 6 5\nBSTONE 1\nBORDER 7 1 2\nEND\n",
    "control nodes (CNXYZ)": HEAD + re.sub(r"(VRTX.*)", r"\1 CNXYZ", MESH),
    "properties and control nodes": HEAD + PROPERTIES + re.sub(r"VRTX(.*)", r"PVRTX\1 7 -99999 CNXYZ", MESH),
    "ids from 101": HEAD
    + "TFACE\nVRTX 101 0 0 1\nVRTX 102 1 0 2\nVRTX 103 0 1 3\nVRTX 104 1 1 4\n"
    + "TRGL 101 102 103\nTRGL 102 104 103\nEND\n",
    "parts, borders, key vertices": HEAD
    + "TFACE\nKEYVERTICES 1 2 3\nVRTX 1 0 0 1\nVRTX 2 1 0 2\nVRTX 3 0 1 3\nTRGL 1 2 3\n"
    + "BSTONE 1\nBORDER 90 1 2\n"
    + "TFACE\nPATOM 4 2 7 8\nPVRTX 5 1 1 4 7 8\nATOM 6 3\nTRGL 4 5 6\nBSTONE 5\nBORDER 91 5 6\nEND\n",
    "a line of the same file before": "GOCAD PLine 1\nHEADER {\nname:L\n}\nILINE\nVRTX 1 x y z\nEND\n"
    + HEAD
    + MESH,
    "Model3d": model3d(HEAD + MESH),
    "Model3d of depths": model3d(HEAD + DEPTHS, "Depth"),
    "Model3d of depths, surface of elevations": model3d(HEAD + frame("Elevation") + MESH, "Depth"),
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
    "Model3d alone": (model3d(""), ("Model3d", "no TSurf")),
    "Model3d cut short": (model3d("")[:120], ("line 1", "cut short")),
    "Model3d of which a surface is cut short": (model3d(HEAD + MESH[:-4]), ("line 25", "cut short")),
    "Model3d of an unknown sign": (model3d(HEAD + MESH, "Up"), ("line 9", "'Up'")),
    "zero bytes": (HEAD + "\0\0\0" + MESH, ("not a text file",)),
}
