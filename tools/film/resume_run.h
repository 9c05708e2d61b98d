#pragma once
/// A run that is resumed where it stopped.
#include "tools/film/run.h"

namespace whorl {

/// Completes a request for the run in its folder, whose scene is request.file as it stands there now: the newest checkpoint, and where to
/// end (request.frames, where nothing was asked, is what the run was to make). Where no checkpoint was written yet, the run begins again;
/// frames that stand there are kept under another name. Tells on standard error which checkpoints are damaged.
/// @throws InputError where there is none that is sound, or none of a run that is over, or it is another build's or of other settings (with
/// each of them)
void resume_from_newest(RunRequest& request);

/// @param made frames that the run has @throws InputError where it is wanted to end before them
void check_end(const std::filesystem::path& folder, const Scene& scene, int made, int wanted);

/// The pictures so far begin the video, and are on the contact sheet. @throws InputError where one of the `made` is missing
void check_pictures(const std::filesystem::path& folder, int made);

}  // namespace whorl
