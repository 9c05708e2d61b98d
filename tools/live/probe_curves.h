#pragma once
/// Probes as JSON, for the curves of a page.
#include <nlohmann/json_fwd.hpp>

#include "engine/probes/comparison.h"

namespace whorl {

/// {"profile": false, "along_unit": "s", "plots": [{"title": "front [m]", "curves": [{"column": "front", "label": "front", "dashed":
/// false}]}]}; a column of the comparison is called compare_NAME.
nlohmann::ordered_json described_plots(const Probe& probe, const std::optional<Comparison>& comparison);
/// The newest row as {"frequency": 2.1, ...}; null where a value is not known.
nlohmann::ordered_json newest_row(const Probe& probe, const ProbeRows& rows, const std::optional<Comparison>& comparison);
/// Of a probe that measures several places a frame: {"s": [0, 0.1, ...], "pressure": [...], ...}, some hundred places at most.
nlohmann::ordered_json profile_of(const Probe& probe, const ProbeRows& rows, const std::optional<Comparison>& comparison);

}  // namespace whorl
