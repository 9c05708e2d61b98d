#pragma once
/// Font of all text in images. DejaVu Sans is part of the program, so that text looks the same on every machine.
/// Only .cpp files of this folder include this header, because it includes Cairo.
#include <cairo.h>

#include <memory>
#include <string>
#include <vector>

namespace whorl {

struct CairoFree {
    void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
    void operator()(cairo_t* c) const { cairo_destroy(c); }
    void operator()(cairo_scaled_font_t* f) const { cairo_scaled_font_destroy(f); }
};
using CairoSurface = std::unique_ptr<cairo_surface_t, CairoFree>;
using CairoContext = std::unique_ptr<cairo_t, CairoFree>;

/// Letters of one size on one line.
struct TextRun {
    std::string text;
    double x = 0;     ///< start of the run, from the start of the text [pixels]
    double rise = 0;  ///< rise of the baseline [pixels]
    double size = 0;  ///< font size [pixels]
};
struct TextLine {
    std::vector<TextRun> runs;
    double width = 0;  ///< pixels
};

/// Height of a capital letter over the font's size.
inline constexpr double capital_height = 0.729;

/// Splits a text into runs. "^" raises the digits, signs and points that follow it, as an exponent.
/// @param size font size [pixels]
TextLine lay_out(const std::string& text, double size);
/// Calls draw (cairo_show_text or cairo_text_path) for every run of a line whose baseline starts at x, y.
void draw_line(cairo_t* to, const TextLine& line, double x, double y, void (*draw)(cairo_t*, const char*));

}  // namespace whorl
