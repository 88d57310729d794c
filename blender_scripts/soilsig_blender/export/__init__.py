"""The files: meshes, the placed scene, Blender's own files and the report."""
