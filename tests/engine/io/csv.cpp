#include "engine/io/csv.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "engine/core/errors.h"
#include "tests/support/scratch.h"

using namespace whorl;

TEST_CASE("a table is read as it was written, with commas and quotes in its cells", "[io][csv]") {
    const test::ScratchFolder folder;
    const std::vector<std::string> columns{"plain", csv_cell("gravity=[0, -9.81, 0]"), csv_cell("the \"fine\" one")};
    CHECK(columns[2] == "\"the \"\"fine\"\" one\"");
    std::ofstream(folder / "table.csv") << csv_header(columns) << "\n"
                                        << csv_lines({{1, std::numeric_limits<double>::quiet_NaN(), 3.5}}) << "2,"
                                        << csv_cell("no number, but \"text\"") << ",4\n";
    const CsvTable table = read_csv(folder / "table.csv");
    CHECK(table.columns == std::vector<std::string>{"plain", "gravity=[0, -9.81, 0]", "the \"fine\" one"});
    REQUIRE(table.rows.size() == 2);
    CHECK(table.rows[0][0] == 1);
    CHECK(std::isnan(table.rows[0][1]));
    CHECK(table.rows[0][2] == 3.5);
    CHECK(table.rows[1][0] == 2);
    CHECK(std::isnan(table.rows[1][1]));
    CHECK(table.rows[1][2] == 4);
}

TEST_CASE("a table of another program is read with its byte-order mark, comments, blanks and line ends", "[io][csv]") {
    const test::ScratchFolder folder;
    std::ofstream(folder / "table.csv") << "\xef\xbb\xbftime, height \r\n# the second run\r\n 0 , 1.5\r\n1,2\r\n";
    const CsvTable table = read_csv(folder / "table.csv");
    CHECK(table.columns == std::vector<std::string>{"time", "height"});
    CHECK(table.rows == std::vector<std::vector<double>>{{0, 1.5}, {1, 2}});
}

TEST_CASE("a new table can be read and written by its owner, and a full disk is an error", "[io][csv]") {
    const test::ScratchFolder folder;
    const Table table(folder / "rows.csv", std::string_view("a,b"));
    const auto owner = std::filesystem::status(table.file()).permissions() & std::filesystem::perms::owner_all;
    CHECK(owner == (std::filesystem::perms::owner_read | std::filesystem::perms::owner_write));
    CHECK_THROWS_WITH(Table("/dev/full", std::string_view("a,b")), Catch::Contains("cannot write /dev/full"));
}
