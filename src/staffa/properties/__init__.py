"""Functions of position that a case may give: formulas, random fields, fields on meshes."""
