#pragma once
/// Table of an experiment or a theory with which a probe is compared (key `compare`).
#include <optional>

#include "engine/io/csv.h"
#include "engine/probes/probes.h"

namespace whorl {

struct Comparison {
    CsvTable table;         ///< rows in ascending order of the column `along`
    std::string name;       ///< file name without its extension
    std::size_t along = 0;  ///< index of the column for the horizontal axis: time, or a position with several rows per frame

    bool has(const std::string& column) const { return table.has(column); }
    /// Value of a column, interpolated linearly between rows; NaN outside the range of the rows.
    double at(const std::string& column, double along_value) const;
};

/// The table that the scene names for a probe; empty if it names none. @throws InputError, at the key `compare`, if the columns of the
/// table do not match those of the probe
std::optional<Comparison> comparison_of(const Scene& scene, std::size_t probe, const Probe& columns_of);

/// @throws InputError with all probes of the scene that cannot measure (a gauge off its surface) or cannot be compared
void check_probes(const Simulation& simulation);

}  // namespace whorl
