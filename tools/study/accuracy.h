#pragma once
/// How wrong a run is, by what its study calls accurate.
#include "tools/study/point.h"

namespace whorl {

/// The relative error of the run in `folder` (0.01: one per cent); of kind picture: the mean CIE76 difference of the last picture.
/// NaN where the run has no row that counts. @param reference folder of the run that counts as true; empty where none is needed
double error_of(const AccuracyKeys& accuracy, const std::filesystem::path& folder, const std::filesystem::path& reference);

}  // namespace whorl
