#pragma once
/// Table of an experiment or a theory that a probe is compared with (its key `compare`).
#include <optional>

#include "engine/io/csv.h"
#include "engine/probes/probes.h"

namespace whorl {

struct Comparison {
    CsvTable table;         ///< rows in rising order of the column along
    std::string name;       ///< of the file, without its extension
    std::size_t along = 0;  ///< column: time, or the place of which every frame has several

    bool has(const std::string& column) const { return table.has(column); }
    /// Value of a column, interpolated straight between the rows; NaN beyond them.
    double at(const std::string& column, double along_value) const;
};

/// The probe's table, none if the scene names none. @throws InputError, at the key, if the file cannot be compared with the probe's columns
std::optional<Comparison> comparison_of(const Scene& scene, std::size_t probe, const Probe& columns_of);

/// @throws InputError with all probes of the scene that cannot measure (a gauge off its surface) or be compared
void check_probes(const Simulation& simulation);

}  // namespace whorl
