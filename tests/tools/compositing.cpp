// Runs for compositing: EXR images, and images without a background.
#include <catch2/catch.hpp>

#include "engine/io/csv.h"
#include "render/image/exr.h"
#include "render/video/process.h"
#include "tests/support/film_runs.h"
#include "tests/support/program.h"
#include "tests/support/scenes.h"
#include "tools/film/contact_sheet.h"

using namespace whorl;
using test::Outcome;
namespace fs = std::filesystem;

namespace compositing_test {

namespace {

using Scratch = test::FilmScratch;

/// A drop of honey over a plate.
const std::string drop = test::little_honey("end = 0.1\nfps = 40", 4e-3, R"([[block]]
shape = "sphere"
position = [0, 0.02, 0]
radius = 0.01
[[solid]]
shape = "plane"
[output]
size = [160, 90]
export = ["raw"]
format = "exr"
)");
const std::string camera = R"([camera]
kind = "orbit"
target = [0, 0.02, 0]
distance = 0.2
height = 0.1
degrees_per_second = 100
)";

std::string stream_of(const fs::path& video, const std::string& entry) {
    ChildProcess probe({"ffprobe", "-v", "error", "-show_entries", "stream=" + entry, "-of", "default=nk=1:nw=1", video.string()});
    REQUIRE(probe.wait() == 0);
    return probe.output().substr(0, probe.output().find('\n'));
}

/// The first frame of a video as ffmpeg decodes it, with alpha.
Image first_frame(const fs::path& video, const fs::path& file, const std::vector<std::string>& decoder = {}) {
    std::vector<std::string> words{"ffmpeg", "-nostdin", "-loglevel", "error", "-y"};
    words.insert(words.end(), decoder.begin(), decoder.end());
    words.insert(words.end(), {"-i", video.string(), "-frames:v", "1", "-pix_fmt", "rgba", file.string()});
    ChildProcess decode(words);
    const int status = decode.wait();
    INFO(decode.output());
    REQUIRE(status == 0);
    return read_png(file);
}

}  // namespace

TEST_CASE("EXR images of a run are the same when resumed or drawn again, and make its video", "[tools][exr]") {
    const Scratch scratch(drop + camera);
    scratch.render({}, "whole");
    scratch.render({"--frames", "2"});
    test::succeed({"resume", scratch.run("run"), "--frames", "5", "--quiet"});
    const auto picture = [&](const char* run, int frame) { return read_whole(picture_file(scratch / run, frame, "exr")); };
    for (const int frame : {1, 3, 5}) CHECK((picture("whole", frame) == picture("run", frame)));
    CHECK(test::files_in(scratch / "whole/frames").size() == 5);
    CHECK(read_png(scratch / "whole/contact.png").width > 160);
    const PictureLayers layers = read_exr(picture_file(scratch / "whole", 3, "exr"));
    CHECK((layers.shadow.empty() && !layers.depth.empty() && !layers.motion.empty()));
    // Seen from the camera the drop turns by 2.5 degrees, 0.44 mm at its surface: a third of a pixel.
    float most = 0;
    for (std::size_t i = 0; i < layers.id.size(); ++i)
        if (layers.id[i] == 1) most = std::max(most, std::abs(layers.motion[2 * i]));
    CHECK(most == Approx(0.33).margin(0.1));

    const std::string film = read_whole(scratch / "whole/little_honey.mp4");
    test::succeed({"video", scratch.run("whole")});
    CHECK((read_whole(scratch / "whole/little_honey.mp4") == film));
    test::succeed({"draw", scratch.run("whole"), "--quiet", "--out", scratch.run("again")});
    CHECK((picture("again", 3) == picture("whole", 3)));
    // Another format replaces the existing images.
    test::succeed({"draw", scratch.run("whole"), "--quiet", "--frames", "3", "--set", "output.format=png"});
    CHECK(fs::exists(picture_file(scratch / "whole", 3)));
    CHECK_FALSE(fs::exists(picture_file(scratch / "whole", 3, "exr")));
}

TEST_CASE("a transparent run keeps its alpha in PNG, MOV and WebM, and MP4 shows it over grey", "[tools][exr]") {
    const Scratch scratch(drop);
    scratch.render({"--frames", "2", "--set", "look.background=transparent", "--set", "output.format=png"});
    const Image picture = read_png(picture_file(scratch / "run", 1));
    REQUIRE_FALSE(picture.alpha.empty());
    CHECK(picture.alpha[0] == 0);
    test::succeed({"video", scratch.run(), "--out", (scratch / "a.mov").string()});
    CHECK(stream_of(scratch / "a.mov", "codec_name") == "prores");
    CHECK(stream_of(scratch / "a.mov", "pix_fmt").substr(0, 7) == "yuva444");
    test::succeed({"video", scratch.run(), "--out", (scratch / "a.webm").string()});
    // ProRes is nearly lossless. VP9 and its alpha are lossy.
    for (const auto& [name, decoder, mean] :
         {std::tuple{"a.mov", std::vector<std::string>{}, 0.5}, {"a.webm", {"-c:v", "libvpx-vp9"}, 4.0}}) {
        const Image frame = first_frame(scratch / name, scratch / "frame.png", decoder);
        REQUIRE(frame.alpha.size() == picture.alpha.size());
        double sum = 0;
        for (std::size_t i = 0; i < frame.alpha.size(); ++i) sum += std::abs(frame.alpha[i] - picture.alpha[i]);
        INFO(name);
        CHECK(sum / static_cast<double>(frame.alpha.size()) < mean);
    }
    CHECK_THAT(test::succeed({"video", scratch.run()}).err, Catch::Contains(".mp4 has no alpha: the images are drawn over grey"));
    const Image grey = first_frame(scratch / "run/little_honey.mp4", scratch / "grey.png");
    CHECK(std::abs(grey.rgb[0] - 118) <= 3);
}

TEST_CASE("unsupported settings of EXR and transparent images are reported at their key", "[tools][exr]") {
    const Scratch scratch(drop);
    const auto refused = [&](const std::vector<std::string>& set, const std::string& why) {
        std::vector<std::string> words{"render", scratch.scene(), "--out", scratch.run("refused"), "--quiet"};
        for (const std::string& s : set) words.insert(words.end(), {"--set", s});
        CHECK_THAT(test::refusal(words), Catch::Contains(why));
        CHECK_FALSE(fs::exists(scratch / "refused"));
    };
    refused({"output.format=tiff"}, "png or exr");
    refused({"look.style=slice"}, "a slice that fills the image has only the colours of a screen");
    refused({"look.style=slice", "output.format=png", "look.background=transparent"}, "has no background");
    refused({"look.background=transparent", "look.table=wood"}, "only the shadow on the ground is drawn");
    const Scratch panels(drop + "[[panel]]\nlabel = \"a\"\n[[panel]]\nlabel = \"b\"\n");
    CHECK_THAT(test::refusal({"render", panels.scene(), "--out", panels.run(), "--quiet"}),
               Catch::Contains("has no text, but panels need their labels"));
}

}  // namespace compositing_test
