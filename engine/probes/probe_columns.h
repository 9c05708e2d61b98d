#pragma once
/// Columns of a probe's table, with all that tables, plots and the live page say of them.
#include <string>
#include <vector>

namespace whorl {

struct ProbeColumn {
    std::string name;  ///< theory_NAME: the value of NAME according to theory
    std::string unit;  ///< "" for a bare number
    std::string plot;  ///< title of the diagram that shows the column; empty: no diagram does
};
using ProbeColumns = std::vector<ProbeColumn>;

/// NAME_x, NAME_y and NAME_z, in one diagram.
ProbeColumns vector_columns(const std::string& name, const std::string& unit);
ProbeColumns operator+(ProbeColumns a, const ProbeColumns& b);

/// A diagram of a probe: the columns of the same title.
struct ProbePlot {
    struct Curve {
        std::size_t column = 0;
        std::string label;    ///< in the legend
        bool theory = false;  ///< dashed: expected, not measured
    };
    std::string title, unit;
    std::vector<Curve> curves;
};
std::vector<ProbePlot> plots_of(const ProbeColumns& columns);

/// Header line of the table, without the line's end.
std::string csv_header(const ProbeColumns& columns);

}  // namespace whorl
