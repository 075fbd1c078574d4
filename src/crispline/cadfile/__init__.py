"""CAD files: STEP, IGES, BREP and 3DM, to and from OCCT shapes."""
