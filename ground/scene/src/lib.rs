//! Animated 3D scenes: meshes, materials, lights, cameras, tracks, loaders, demo scenes.
