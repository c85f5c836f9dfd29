"""The workflow's stages: files in, an algorithm, files out. One module a stage."""
