//! Exact minimal cuts on pixel grids, with the canonical labelling.
