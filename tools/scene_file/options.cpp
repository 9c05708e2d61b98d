#include "tools/scene_file/options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace whorl {

NumberCheck whole_number(long long least, long long most) {
    return [=](const std::string& text) -> std::string {
        long long number = 0;
        const char *begin = text.data() + (text[0] == '+' ? 1 : 0), *end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(begin, end, number);
        if (error == std::errc() && stop == end && number >= least && number <= most) return "";
        const bool usual = most == std::numeric_limits<int>::max() && !(stop == end && number != 0 && number >= least);
        return (usual ? fmt::format("must be a whole number, at least {}", least)
                      : fmt::format("must be a whole number from {} to {}", least, most)) +
               ", not \"" + text + "\"";
    };
}

NumberCheck any_number(const std::string& unit, bool above_zero) {
    return [=](const std::string& text) -> std::string {
        char* end = nullptr;
        const double number = std::strtod(text.c_str(), &end);
        if (end != text.c_str() && *end == 0 && (!above_zero || (number > 0 && std::isfinite(number)))) return "";
        return fmt::format("must be a number{}{}, not \"{}\"", above_zero ? " above 0" : "", unit.empty() ? "" : " [" + unit + "]", text);
    };
}

std::string quotient(const std::string& text) {
    const char* const slash = std::strchr(text.c_str(), '/');
    char *above = nullptr, *below = nullptr;
    const double number = std::strtod(text.c_str(), &above), divisor = slash ? std::strtod(slash + 1, &below) : 0;
    return above == slash && divisor > 0 && *below == 0 ? fmt::format("{}", number / divisor) : text;
}

std::string not_empty(const std::string& text) { return text.empty() ? "is empty; give a name, or remove the option" : ""; }

void add_options(CLI::App& app, Options& o, std::initializer_list<const void*> which) {
    const auto has = [&](const auto& member) { return std::find(which.begin(), which.end(), &member) != which.end(); };
    if (has(o.scene))
        app.add_option("scene", o.scene, "scene file, or the name of a shipped scene (honey_coil)")->required()->type_name("SCENE");
    if (has(o.folder)) app.add_option("folder", o.folder, "the run folder, as in out/honey_coil")->required()->type_name("RUN_FOLDER");
    if (has(o.set))
        app.add_option("--set", o.set, "change a key of the scene: fluid.viscosity=100, emitter[0].speed=0.3 (repeatable)")
            ->type_name("KEY=VALUE")
            ->allow_extra_args(false);
    if (has(o.with))
        app.add_option("--with", o.with,
                       "override keys of the scene with those of this file, as written by `whorl tradeoff --recommend` (repeatable)")
            ->type_name("FILE")
            ->allow_extra_args(false);
    if (has(o.out)) app.add_option("--out", o.out, "run folder (default: out/<scene name>)")->type_name("DIR")->check(not_empty);
    if (has(o.overwrite)) app.add_flag("--overwrite", o.overwrite, "replace an existing run in the folder");
    if (has(o.force)) app.add_flag("--force", o.force, "continue even if a mesh, image or table of the scene was edited");
    if (has(o.until)) app.add_option("--until", o.until, "end of the run [s] (time.end)")->type_name("T")->check(any_number("s"));
    if (has(o.frames)) app.add_option("--frames", o.frames, "stop after N frames")->type_name("N")->check(whole_number(1));
    if (has(o.size)) app.add_option("--size", o.size, "size of the images in pixels, as in 1280x720 (output.size)")->type_name("WxH");
    if (has(o.fps))
        app.add_option("--fps", o.fps, "frames per second of the video, as in 25, 29.97 or 24000/1001 (time.fps)")
            ->type_name("N")
            ->transform(quotient)
            ->check(any_number());
    if (has(o.quality))
        app.add_option("--quality", o.quality,
                       "draft, standard or fine: sets samples per pixel and the keys of the scene's table [quality.NAME]")
            ->type_name("NAME");
    if (has(o.no_video)) app.add_flag("--no-video", o.no_video, "write images but no video");
    if (has(o.no_images)) app.add_flag("--no-images", o.no_images, "simulate and measure, but draw no images");
    if (has(o.no_draw)) app.add_flag("--no-draw", o.no_draw, "simulate and export raw frames, which whorl draw draws later");
    if (has(o.exports))
        app.add_option("--export", o.exports,
                       "write points, mesh, obj, vdb, scene, vtk for other programs, raw for whorl draw (separated by commas)")
            ->type_name("KINDS")
            ->delimiter(',')
            ->allow_extra_args(false);
    if (has(o.threads))
        app.add_option("--threads", o.threads, "threads (default: all cores); never changes the result")
            ->type_name("N")
            ->check(whole_number(0, 1024));
    if (has(o.seed))
        app.add_option("--seed", o.seed, "seed of all random numbers (seed)")
            ->type_name("N")
            ->check(whole_number(0, std::numeric_limits<long long>::max()));
    if (has(o.dry_run)) app.add_flag("--dry-run", o.dry_run, "check the scene and options only; run and write nothing");
    if (has(o.quiet)) app.add_flag("--quiet", o.quiet, "print no progress");
    if (has(o.json)) app.add_flag("--json", o.json, "machine-readable progress and result on standard output");
}

}  // namespace whorl
