"""Images: plots by matplotlib (identical bytes for identical numbers), frames of runs by ffmpeg."""
import io


def figure(width, height, draw):
    """SVG of the given size in inches, drawn by draw(axes)."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    with matplotlib.rc_context({"svg.hashsalt": "whorl", "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 10,
                                "axes.spines.top": False, "axes.spines.right": False}):
        canvas, axes = pyplot.subplots(figsize=(width, height), layout="constrained")
        draw(axes)
        content = io.BytesIO()
        canvas.savefig(content, format="svg", metadata={"Date": None, "Creator": None})
        pyplot.close(canvas)
    return content.getvalue()


def picture(m, path, images, width, quality=(), columns=None):
    """Scales images to a width and writes them in rows of `columns` (default: one row) into a file of the documentation."""
    if m.writes:
        (m.into / path).parent.mkdir(parents=True, exist_ok=True)
    elif not m.dry:
        return
    inputs = [part for image in images for part in ("-i", image)]
    scaled = "".join(f"[{k}]scale={width}:-1:flags=area[s{k}];" for k in range(len(images)))
    columns = columns or len(images)
    places = "|".join("+".join(["0", *["w0"] * (k % columns)]) + "_" + "+".join(["0", *["h0"] * (k // columns)]) for k in range(len(images)))
    joined = "".join(f"[s{k}]" for k in range(len(images))) + (f"xstack={len(images)}:layout={places}" if len(images) > 1 else "null")
    m.call(["ffmpeg", "-v", "error", "-y", *inputs, "-filter_complex", scaled + joined, *quality, m.into / path])
