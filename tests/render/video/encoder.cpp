#include "render/video/encoder.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "engine/core/errors.h"
#include "render/video/process.h"
#include "tests/support/pictures.h"
#include "tests/support/scratch.h"

using namespace whorl;
using test::flat_picture;

namespace {

std::string output_of(const std::vector<std::string>& arguments) {
    ChildProcess child(arguments);
    const int status = child.wait();
    INFO(child.output());
    REQUIRE(status == 0);
    return child.output();
}

// Every frame of the video, decoded by ffmpeg according to the file's tags.
std::vector<Image> decoded(const std::filesystem::path& video, const test::ScratchFolder& folder) {
    output_of({"ffmpeg", "-nostdin", "-loglevel", "error", "-i", video.string(), "-vf",
               "scale=out_range=pc:flags=bicubic+accurate_rnd+full_chroma_int", "-pix_fmt", "rgb24", (folder / "frame%04d.png").string()});
    std::vector<Image> images;
    for (int i = 1;; ++i) {
        char name[32];
        std::snprintf(name, sizeof name, "frame%04d.png", i);
        if (!std::filesystem::exists(folder / name)) return images;
        images.push_back(read_png(folder / name));
    }
}

std::string tags(const std::filesystem::path& video) {
    return output_of({"ffprobe", "-v", "error", "-select_streams", "v", "-show_entries",
                      "stream=codec_name,pix_fmt,color_range,color_space,color_transfer,color_primaries,avg_frame_rate", "-of",
                      "default=nk=0:nw=1", video.string()});
}

// A search for *.mp4 must not find a partial video.
void check_hidden(const std::vector<std::string>& names, const std::filesystem::path& video) {
    CHECK_FALSE(names.empty());
    for (const std::filesystem::path name : names) {
        CHECK(name.string().front() == '.');
        CHECK(name.extension() != video.extension());
    }
}

// A file's top-level boxes in order, by their four-letter names.
std::vector<std::string> boxes(const std::filesystem::path& video) {
    std::ifstream in(video, std::ios::binary);
    std::vector<std::string> names;
    unsigned char head[8];
    while (in.read(reinterpret_cast<char*>(head), 8)) {
        names.emplace_back(reinterpret_cast<char*>(head) + 4, 4);
        const std::streamoff size = head[0] << 24 | head[1] << 16 | head[2] << 8 | head[3];
        in.seekg(size - 8, std::ios::cur);
    }
    return names;
}

}  // namespace

TEST_CASE("flat colours survive the video within 2/255", "[video]") {
    test::ScratchFolder folder;
    // Honey, shadow, glass, white, black, and the corners of the cube.
    const std::vector<std::array<std::uint8_t, 3>> colours = {{214, 137, 16},  {90, 45, 5},    {128, 160, 170}, {255, 255, 255},
                                                              {0, 0, 0},       {255, 0, 0},    {0, 255, 0},     {0, 0, 255},
                                                              {128, 128, 128}, {250, 240, 200}};
    VideoEncoder encoder(folder / "flat.mp4", 64, 48, {});
    for (const auto& c : colours) encoder.add(flat_picture(64, 48, c[0], c[1], c[2]));
    encoder.finish();
    const std::vector<Image> frames = decoded(folder / "flat.mp4", folder);
    REQUIRE(frames.size() == colours.size());
    for (std::size_t f = 0; f < frames.size(); ++f)
        for (std::size_t i = 0; i < frames[f].rgb.size(); ++i)
            if (std::abs(frames[f].rgb[i] - colours[f][i % 3]) > 2) {
                INFO("frame " << f << " channel " << i % 3 << ": " << int(frames[f].rgb[i]) << " for " << int(colours[f][i % 3]));
                REQUIRE(false);
            }
}

TEST_CASE("a finished video is tagged, starts fast and leaves no partial file", "[video]") {
    test::ScratchFolder folder;
    const auto names = test::names_made(folder.path(), [&] {
        VideoEncoder encoder(folder / "film.mp4", 65, 49, {29.97, 18});  // odd sizes lose a row and a column
        for (int i = 0; i < 12; ++i) encoder.add(test::studio_picture(65, 49));
        encoder.finish();
    });
    check_hidden(names, "film.mp4");
    const std::string found = tags(folder / "film.mp4");
    for (const char* tag : {"codec_name=h264", "pix_fmt=yuv420p", "color_range=tv", "color_space=bt709", "color_transfer=bt709",
                            "color_primaries=bt709", "avg_frame_rate=30000/1001"}) {
        INFO(found);
        REQUIRE(found.find(tag) != std::string::npos);
    }
    const auto order = boxes(folder / "film.mp4");
    const auto at = [&](const char* name) { return std::find(order.begin(), order.end(), name) - order.begin(); };
    REQUIRE(at("moov") < at("mdat"));
    REQUIRE_FALSE(std::filesystem::exists(partial_video(folder / "film.mp4")));
    const std::vector<Image> frames = decoded(folder / "film.mp4", folder);
    REQUIRE(frames.size() == 12);
    REQUIRE((frames[0].width == 64 && frames[0].height == 48));
}

TEST_CASE("the suffix decides how a video is encoded", "[video]") {
    for (const auto& [name, codec] :
         {std::pair{"film.mov", "codec_name=prores"}, {"film.webm", "codec_name=vp9"}, {"film.gif", "codec_name=gif"}}) {
        test::ScratchFolder folder;
        const auto names = test::names_made(folder.path(), [&] {
            VideoEncoder encoder(folder / name, 64, 48, {20, 18});
            for (int i = 0; i < 10; ++i) encoder.add(flat_picture(64, 48, static_cast<std::uint8_t>(20 * i), 100, 50));
            encoder.finish();
        });
        check_hidden(names, name);
        const std::string found = tags(folder / name);
        INFO(name << ": " << found);
        CHECK(found.find(codec) != std::string::npos);
        CHECK(found.find("avg_frame_rate=20/1") != std::string::npos);
        for (const char* tag : {"color_range=tv", "color_space=bt709", "color_transfer=bt709", "color_primaries=bt709"})
            CHECK((found.find(tag) != std::string::npos || std::string(name) == "film.gif"));
        CHECK(decoded(folder / name, folder).size() == 10);
        CHECK_FALSE(std::filesystem::exists(partial_video(folder / name)));
    }
}

TEST_CASE("a video plays nearly to the end after run and encoder are killed", "[video]") {
    test::ScratchFolder folder;
    const int frames = 72;
    int ready[2];
    REQUIRE(pipe(ready) == 0);
    const pid_t maker = fork();
    if (maker == 0) {  // a separate run with its encoder in one process group, as under a shell that is killed
        VideoEncoder encoder(folder / "film.mp4", 160, 90, {});
        const Image image = test::studio_picture(160, 90);
        for (int i = 0; i < frames; ++i) encoder.add(image);
        usleep(700000);
        if (write(ready[1], "x", 1) != 1) _exit(1);
        pause();
    }
    char byte;
    REQUIRE(read(ready[0], &byte, 1) == 1);
    // The current file is what remains if all processes are killed together: check a copy of it.
    std::filesystem::copy_file(partial_video(folder / "film.mp4"), folder / "seized.mp4");
    kill(maker, SIGKILL);
    waitpid(maker, nullptr, 0);
    close(ready[0]);
    close(ready[1]);
    // Missing frames: 8 of x264's look-ahead, its B frames, and a fragment of a quarter of a second (6 frames).
    const auto seized = decoded(folder / "seized.mp4", folder).size();
    REQUIRE(seized >= frames - 20);
    REQUIRE(seized <= frames);
    // If only the run was killed, ffmpeg reads the end of its input and completes the file.
    const auto packets = [&] {
        ChildProcess count({"ffprobe", "-v", "quiet", "-count_packets", "-select_streams", "v", "-show_entries", "stream=nb_read_packets",
                            "-of", "csv=p=0", partial_video(folder / "film.mp4").string()});
        return count.wait() == 0 ? std::atoi(count.output().c_str()) : 0;
    };
    for (int wait = 0; wait < 50 && packets() < frames; ++wait) usleep(100000);
    REQUIRE(packets() == frames);
}

TEST_CASE("an encoder that is dropped leaves a complete partial video", "[video]") {
    test::ScratchFolder folder;
    {
        VideoEncoder encoder(folder / "film.mp4", 64, 48, {});
        for (int i = 0; i < 10; ++i) encoder.add(flat_picture(64, 48, 10, 20, 30));
    }
    REQUIRE_FALSE(std::filesystem::exists(folder / "film.mp4"));
    REQUIRE(decoded(partial_video(folder / "film.mp4"), folder).size() == 10);
}

TEST_CASE("without ffmpeg the error names the package", "[video]") {
    test::ScratchFolder folder;
    const std::string path = std::getenv("PATH");
    setenv("PATH", folder.path().c_str(), 1);
    std::string message;
    try {
        VideoEncoder encoder(folder / "film.mp4", 64, 48, {});
    } catch (const EnvironmentError& error) { message = error.what(); }
    CHECK_THROWS_WITH(check_encoder("or so"), Catch::Contains("cannot start ffmpeg: ") && Catch::EndsWith("apt-get install ffmpeg, or so"));
    const std::string version = encoder_version();
    setenv("PATH", path.c_str(), 1);
    REQUIRE(message.find("apt-get install ffmpeg") != std::string::npos);
    REQUIRE(version.empty());
    REQUIRE(encoder_version().rfind("ffmpeg version", 0) == 0);
}

TEST_CASE("an encoder that fails reports why and raises no signal", "[video]") {
    test::ScratchFolder folder;
    VideoEncoder encoder(folder / "missing" / "film.mp4", 640, 480, {});
    const Image image = flat_picture(640, 480, 0, 0, 0);
    std::string message;
    try {
        for (int i = 0; i < 100; ++i) encoder.add(image);
        encoder.finish();
    } catch (const EnvironmentError& error) { message = error.what(); }
    REQUIRE(message.find("No such file") != std::string::npos);
    REQUIRE(check_encoder() == encoder_version());
    // Encoders without a message, killed by a signal, and without a version.
    const std::string path = std::getenv("PATH");
    setenv("PATH", (folder.path().string() + ":" + path).c_str(), 1);
    const auto words_of = [&](const std::string& script) {
        std::ofstream(folder / "ffmpeg") << "#!/bin/bash\n" << script;
        std::filesystem::permissions(folder / "ffmpeg", std::filesystem::perms::owner_all);
        try {
            check_encoder();
            VideoEncoder fake(folder / "film.mp4", 640, 480, {});
            for (int i = 0; i < 100; ++i) fake.add(image);
            fake.finish();
        } catch (const std::exception& error) { return std::string(error.what()); }
        return std::string();
    };
    const std::string version = "[ \"$1\" = -version ] && exit 0\n", early = "the video encoder ended early: ffmpeg ",
                      then = "\n  remedy: once ffmpeg works, use whorl resume";
    CHECK_THAT(words_of(version + "exit 1"), Catch::StartsWith(early + "ended with code 1" + then));
    CHECK_THAT(words_of(version + "echo no room >&2; exit 3"), Catch::StartsWith(early + "ended with code 3: no room" + then));
    CHECK_THAT(words_of(version + "kill -9 $$"), Catch::StartsWith(early + "was killed by signal 9" + then));
    CHECK_THAT(words_of("echo torn >&2; exit 127"),
               Catch::Contains("cannot start ffmpeg: ffmpeg ended with code 127: torn\n  remedy: repair ffmpeg"));
    setenv("PATH", path.c_str(), 1);
}
