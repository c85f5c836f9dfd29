"""Image files and videos: their headers, pixels, previews, sharpness and matches."""
