#include "render/image/font.h"

#include <cairo-ft.h>

#include <cctype>

#include "engine/core/errors.h"

// The font file, unchanged, in the program's read-only data.
asm(".section .rodata\n"
    ".global whorl_font, whorl_font_end\n"
    ".hidden whorl_font, whorl_font_end\n"
    "whorl_font: .incbin \"" WHORL_FONT
    "\"\n"
    "whorl_font_end: .byte 0\n"
    ".previous");
extern "C" const unsigned char whorl_font[], whorl_font_end[];

namespace whorl {
namespace {

constexpr double exponent_size = 0.62, exponent_rise = 0.36;  // over the font's size

cairo_font_face_t* font_face() {
    static cairo_font_face_t* const face = [] {
        FT_Library library = nullptr;
        FT_Face letters = nullptr;
        const bool read = FT_Init_FreeType(&library) == 0 &&
                          FT_New_Memory_Face(library, whorl_font, static_cast<FT_Long>(whorl_font_end - whorl_font), 0, &letters) == 0;
        WHORL_ASSERT(read);
        return cairo_ft_font_face_create_for_ft_face(letters, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP);
    }();
    return face;
}

/// Options without rounding to pixels, so that letters keep their shape and spacing at every size.
cairo_font_options_t* font_options() {
    static cairo_font_options_t* const options = [] {
        cairo_font_options_t* o = cairo_font_options_create();
        cairo_font_options_set_antialias(o, CAIRO_ANTIALIAS_GRAY);
        cairo_font_options_set_hint_style(o, CAIRO_HINT_STYLE_NONE);
        cairo_font_options_set_hint_metrics(o, CAIRO_HINT_METRICS_OFF);
        return o;
    }();
    return options;
}

double width_of(const std::string& text, double size) {
    cairo_matrix_t scale, identity;
    cairo_matrix_init_scale(&scale, size, size);
    cairo_matrix_init_identity(&identity);
    const std::unique_ptr<cairo_scaled_font_t, CairoFree> font(cairo_scaled_font_create(font_face(), &scale, &identity, font_options()));
    cairo_text_extents_t extents;
    cairo_scaled_font_text_extents(font.get(), text.c_str(), &extents);
    return extents.x_advance;
}

bool in_exponent(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '+' || c == '.'; }

}  // namespace

TextLine lay_out(const std::string& text, double size) {
    TextLine line;
    const auto add = [&](const std::string& letters, bool raised) {
        if (letters.empty()) return;
        const TextRun run{letters, line.width, raised ? exponent_rise * size : 0, raised ? exponent_size * size : size};
        line.width += width_of(run.text, run.size);
        line.runs.push_back(run);
    };
    std::size_t begin = 0;
    for (std::size_t hat = text.find('^'); hat != std::string::npos && hat + 1 < text.size(); hat = text.find('^', begin)) {
        add(text.substr(begin, hat - begin), false);
        begin = hat + 1;
        while (begin < text.size() && in_exponent(text[begin])) ++begin;
        add(text.substr(hat + 1, begin - hat - 1), true);
    }
    add(text.substr(begin), false);
    return line;
}

void draw_line(cairo_t* to, const TextLine& line, double x, double y, void (*draw)(cairo_t*, const char*)) {
    cairo_set_font_face(to, font_face());
    cairo_set_font_options(to, font_options());
    for (const TextRun& run : line.runs) {
        cairo_set_font_size(to, run.size);
        cairo_move_to(to, x + run.x, y - run.rise);
        draw(to, run.text.c_str());
    }
}

}  // namespace whorl
