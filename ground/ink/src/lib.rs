//! Marks on paper: label images to smooth borders and drawn pixel lines.
