#pragma once
/// The letters of everything that is drawn. DejaVu Sans is part of the program, so words look the same on every machine.
/// For the .cpp files of this folder only, which include Cairo.
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
    double x = 0;     ///< where it begins, from the start of the text [pixels]
    double rise = 0;  ///< of the baseline [pixels]
    double size = 0;  ///< of the font [pixels]
};
struct TextLine {
    std::vector<TextRun> runs;
    double width = 0;  ///< pixels
};

/// Height of a capital letter over the font's size.
inline constexpr double capital_height = 0.729;

/// The text in runs. "^" makes an exponent of the digits and signs that follow it.
/// @param size of the font [pixels]
TextLine lay_out(const std::string& text, double size);
/// Calls draw (cairo_show_text or cairo_text_path) for every run of a line whose baseline begins at x, y.
void draw_line(cairo_t* to, const TextLine& line, double x, double y, void (*draw)(cairo_t*, const char*));

}  // namespace whorl
