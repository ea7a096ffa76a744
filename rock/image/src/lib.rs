//! Planes of pixels, colour, filters, codecs and picture metrics.
