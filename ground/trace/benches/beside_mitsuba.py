#!/usr/bin/env python3
"""The path tracer against Mitsuba 3: the mean radiance of a Cornell box, three bounces.

    pip install mitsuba trimesh numpy
    python3 beside_mitsuba.py PATH/TO/chiaro [MESH]

With a mesh, that stands in the box instead of the two blocks. Both renderers get the same triangles,
flat normals, reflectances and emission; the ratio of their means is printed for each channel.
"""

import base64
import json
import pathlib
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np
import trimesh

mi.set_variant("scalar_rgb")

SIZE, PATHS, BOUNCES = 192, 128, 3
EYE, FOV = [0, 1, 4.2], 38.0
WHITE, RED, GREEN = [0.73, 0.735, 0.729], [0.611, 0.0555, 0.062], [0.117, 0.4125, 0.115]


def block(low, high, angle):
    mesh = trimesh.creation.box(bounds=[low, high])
    turn = trimesh.transformations.rotation_matrix(angle, [0, 1, 0], mesh.centroid)
    mesh.apply_transform(turn)
    return mesh.vertices, mesh.faces, WHITE, None


def parts(path):
    """Vertices, faces, reflectance and emission of every part."""
    quads = [
        ([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], WHITE, None),
        ([[-1, 2, 1], [-1, 2, -1], [1, 2, -1], [1, 2, 1]], WHITE, None),
        ([[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]], WHITE, None),
        ([[-1, 0, 1], [-1, 0, -1], [-1, 2, -1], [-1, 2, 1]], RED, None),
        ([[1, 0, 1], [1, 2, 1], [1, 2, -1], [1, 0, -1]], GREEN, None),
        (
            [[-0.24, 1.98, 0.19], [-0.24, 1.98, -0.19], [0.24, 1.98, -0.19], [0.24, 1.98, 0.19]],
            [0, 0, 0],
            [17, 12, 4],
        ),
    ]
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    all_parts = [(np.array(corners, float), faces, c, e) for corners, c, e in quads]
    if path is None:
        all_parts.append(block([-0.7, 0, -0.7], [-0.1, 1.2, -0.1], 0.3))
        all_parts.append(block([0.1, 0, 0], [0.7, 0.6, 0.6], -0.3))
        return all_parts
    mesh = trimesh.load(path, process=True, force="mesh")
    mesh.apply_translation(-mesh.bounds.mean(0))
    mesh.apply_scale(1.5 / mesh.extents.max())
    mesh.apply_translation([0, -mesh.bounds[0][1], 0])
    all_parts.append((mesh.vertices, mesh.faces, [0.6, 0.5, 0.4], None))
    return all_parts


def write_gltf(all_parts, path):
    data, views, accessors, meshes, materials = b"", [], [], [], []
    for vertices, faces, colour, emission in all_parts:
        corners = np.asarray(vertices, np.float32)[np.asarray(faces).ravel()]
        edges = corners[1::3] - corners[0::3], corners[2::3] - corners[0::3]
        normals = np.cross(*edges)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
        normals = np.repeat(normals, 3, 0).astype(np.float32)
        first = len(accessors)
        for values in (corners, normals):
            views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
            accessors.append({
                "bufferView": len(views) - 1, "componentType": 5126, "count": len(values),
                "type": "VEC3", "min": values.min(0).tolist(), "max": values.max(0).tolist(),
            })
            data += values.tobytes()
        material = {
            "pbrMetallicRoughness": {
                "baseColorFactor": colour + [1], "metallicFactor": 0, "roughnessFactor": 1,
            }
        }
        if emission:
            strength = max(emission)
            material["emissiveFactor"] = [e / strength for e in emission]
            extension = {"emissiveStrength": strength}
            material["extensions"] = {"KHR_materials_emissive_strength": extension}
        materials.append(material)
        attributes = {"POSITION": first, "NORMAL": first + 1}
        meshes.append({
            "primitives": [{"attributes": attributes, "material": len(materials) - 1}]
        })
    nodes = [{"mesh": i} for i in range(len(meshes))] + [{"camera": 0, "translation": EYE}]
    perspective = {"yfov": np.deg2rad(FOV), "znear": 0.01, "aspectRatio": 1}
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    path.write_text(json.dumps({
        "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_emissive_strength"],
        "buffers": [{"byteLength": len(data), "uri": uri}], "bufferViews": views,
        "accessors": accessors, "materials": materials, "meshes": meshes, "nodes": nodes,
        "scenes": [{"nodes": list(range(len(nodes)))}], "scene": 0,
        "cameras": [{"type": "perspective", "perspective": perspective}],
    }))


def mean_by_mitsuba(all_parts, folder):
    to_world = mi.ScalarTransform4f().look_at(EYE, [0, 1, 0], [0, 1, 0])
    film = {
        "type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"},
        "pixel_format": "rgb",
    }
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": BOUNCES + 2, "rr_depth": 100},
        "sensor": {
            "type": "perspective", "fov": FOV, "fov_axis": "y", "to_world": to_world, "film": film,
            "sampler": {"type": "independent", "sample_count": PATHS},
        },
    }
    for i, (vertices, faces, colour, emission) in enumerate(all_parts):
        file = folder / f"part{i}.ply"
        trimesh.Trimesh(vertices, faces, process=False).export(file)
        diffuse = {"type": "diffuse", "reflectance": {"type": "rgb", "value": colour}}
        part = {"type": "ply", "filename": str(file), "face_normals": True}
        if emission:
            part["bsdf"] = diffuse
            part["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": emission}}
        else:
            part["bsdf"] = {"type": "twosided", "both": diffuse}
        scene[f"part{i}"] = part
    return np.array(mi.render(mi.load_dict(scene))).mean((0, 1))


def mean_by_chiaro(program, file, folder):
    out, record = folder / "out.exr", folder / "out.json"
    knobs = ["--set", f"samples={PATHS}", "--set", f"bounces={BOUNCES}"]
    words = ["--method", "path", "--size", f"{SIZE}x{SIZE}", "--json", record, "--quiet"]
    subprocess.run([program, "light", file, "-o", out, *words, *knobs], check=True)
    exposure = json.loads(record.read_text())["settings"]["exposure_factor"]
    bitmap = mi.Bitmap(str(out))
    names = [field.name for field in bitmap.struct_()]
    pixels = np.array(bitmap)
    return np.array([pixels[..., names.index(c)].mean() for c in "RGB"]) / exposure


def main():
    program, mesh = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        all_parts = parts(mesh)
        write_gltf(all_parts, folder / "box.gltf")
        ours = mean_by_chiaro(program, folder / "box.gltf", folder)
        theirs = mean_by_mitsuba(all_parts, folder)
    print("chiaro ", ours, "\nmitsuba", theirs, "\nratio  ", ours / theirs)


if __name__ == "__main__":
    main()
