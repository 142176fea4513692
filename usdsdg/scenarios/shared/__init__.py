"""What the jobs share: folders of meshes and pictures, cameras, lights, output formats."""
