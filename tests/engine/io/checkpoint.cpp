#include "engine/io/checkpoint.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>

#include "engine/core/errors.h"
#include "engine/io/byte_io.h"
#include "engine/io/csv.h"
#include "tests/support/scratch.h"

using namespace whorl;
namespace fs = std::filesystem;

namespace {

Checkpoint at_frame(int frame) {
    Checkpoint c;
    c.build = build_id();
    c.scene = "name = \"test\"\n";
    c.frame = frame;
    c.frames = 96;
    c.wall = 12.5;
    c.stages["pressure"] = {1.5, 2.5, 3};
    c.table_bytes["diagnostics.csv"] = 1234;
    c.probes["coil"] = std::string("\0\1\2", 3);
    c.simulation.assign(1000, static_cast<char>(frame));
    return c;
}

}  // namespace

TEST_CASE("a checkpoint reads back as it was written", "[io][checkpoint]") {
    const test::ScratchFolder folder;
    write_checkpoint(folder.path(), at_frame(7));
    std::vector<std::string> damaged;
    const auto back = newest_checkpoint(folder.path(), damaged);
    REQUIRE(back);
    CHECK(damaged.empty());
    CHECK(back->build == build_id());
    CHECK(back->frame == 7);
    CHECK(back->frames == 96);
    CHECK(back->wall == 12.5);
    CHECK(back->stages.at("pressure").calls == 3);
    CHECK(back->table_bytes.at("diagnostics.csv") == 1234);
    CHECK(back->probes.at("coil") == std::string("\0\1\2", 3));
    CHECK(back->simulation == std::string(1000, '\7'));
}

TEST_CASE("the last two checkpoints and the user's files are kept, and no partial files", "[io][checkpoint]") {
    const test::ScratchFolder folder;
    fs::create_directory(folder / "checkpoints");
    const std::vector<std::string> foreign{"000010.whorl.bak", "0000099.whorl", "99.whorl", "keep.part", "keep.whorl"};
    for (const std::string& name : foreign) std::ofstream(folder / "checkpoints" / name) << "a copy";
    CHECK_FALSE(has_checkpoint(folder.path()));
    std::ofstream(folder / "checkpoints" / ".000998.whorl.part") << "hal";
    for (int frame : {999998, 999999, 1000000}) write_checkpoint(folder.path(), at_frame(frame));
    std::vector<std::string> names, damaged;
    for (const auto& entry : fs::directory_iterator(folder / "checkpoints")) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    std::vector<std::string> expected = foreign;
    expected.insert(expected.end(), {"1000000.whorl", "999999.whorl"});
    std::sort(expected.begin(), expected.end());
    CHECK(names == expected);
    CHECK(newest_checkpoint(folder.path(), damaged)->frame == 1000000);
    CHECK(damaged.empty());
}

TEST_CASE("a damaged checkpoint is named and the previous one is used", "[io][checkpoint]") {
    const test::ScratchFolder folder;
    write_checkpoint(folder.path(), at_frame(3));
    write_checkpoint(folder.path(), at_frame(4));
    const fs::path newest = folder / "checkpoints" / "000004.whorl";
    const std::string sound = read_whole(newest);

    std::string content, message, state = "is damaged";
    SECTION("cut short") { content = sound.substr(0, sound.size() / 2), message = "bytes of"; }
    SECTION("one bit altered") {
        content = sound, message = "checksum";
        content[content.size() / 2] = static_cast<char>(content[content.size() / 2] ^ 1);
    }
    SECTION("empty") { message = "not of this kind"; }
    SECTION("valid checksum, but too little content") { content = add_checksum("WHORLCP3", "few"), message = "ends too early"; }
    std::ofstream(newest, std::ios::binary) << content;
    SECTION("a folder") {
        fs::remove(newest);
        fs::create_directory(newest);
        message = state = "cannot be read";  // It may be valid, so it must not be deleted.
    }

    std::vector<std::string> damaged;
    const auto found = newest_checkpoint(folder.path(), damaged);
    REQUIRE(found);
    CHECK(found->frame == 3);
    REQUIRE(damaged.size() == 1);
    CHECK(damaged[0].find("000004.whorl " + state) != std::string::npos);
    CHECK((damaged[0].find("delete") != std::string::npos) == (state == "is damaged"));
    CHECK(damaged[0].find(message) != std::string::npos);
}

TEST_CASE("a checkpoint with any one byte changed is refused", "[io][checkpoint]") {
    const test::ScratchFolder folder;
    write_checkpoint(folder.path(), at_frame(3));
    const fs::path file = folder / "checkpoints" / "000003.whorl";
    const std::string sound = read_whole(file);
    std::vector<std::size_t> taken;
    for (std::size_t at = 0; at < sound.size(); ++at) {
        std::string changed = sound;
        changed[at] = static_cast<char>(changed[at] ^ (1 << at % 8));
        std::ofstream(file, std::ios::binary) << changed;
        try {
            read_checkpoint(file);
            taken.push_back(at);
        } catch (const EnvironmentError&) {}
    }
    CHECK(taken.empty());
}

TEST_CASE("a table that continues from a checkpoint is truncated to it", "[io][checkpoint]") {
    const test::ScratchFolder folder;
    const fs::path file = folder / "rows.csv";
    std::uint64_t bytes = 0;
    {
        Table table(file, std::string_view("a,b"));
        table.append("1,2\n");
        bytes = table.bytes();
        table.append("3,4\n5,6\n");
    }
    Table(file, bytes).append("7,8\n");
    CHECK(read_whole(file) == "a,b\n1,2\n7,8\n");
    CHECK_THROWS_AS(Table(file, std::uint64_t{1000}), EnvironmentError);
}
