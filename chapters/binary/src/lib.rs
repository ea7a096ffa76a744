//! Binary shading: black and white from appearance and geometry by a minimal cut (thesis, chapter 3).
