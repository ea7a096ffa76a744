//! Shading normals for meshes whose file has none.
