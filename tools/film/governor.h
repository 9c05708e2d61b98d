#pragma once
/// Keeps a run to its budget of time by giving up accuracy in a set order, within bounds that the scene sets: first the solvers'
/// tolerances, then the length of steps, then the surface's voxels, then samples a pixel. Never what the fluid is.
#include <optional>
#include <string>

#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// What was given up, as a number from 0 (nothing) to 4 (all): each unit uses up one of the four, on a logarithmic scale.
struct Sacrifice {
    double amount = 0;
    double tolerance = 1, cfl = 0, voxel = 0;  ///< factor; value; value
    int samples = 0;
};

class Governor {
public:
    /// @param given the scene as the user wants it @param frames of the film
    Governor(const SceneFile& given, int frames);

    /// The user's scene is another one from now on.
    void set_scene(const SceneFile& given);
    /// After a frame. @param seconds it took, wall @param frame its number @param spent s, wall, over the whole run
    /// @return the scene to go on with, where it is another than before
    std::optional<SceneFile> after_frame(double seconds, int frame, double spent);
    /// The scene with what is given up now.
    SceneFile governed() const;

    bool has_budget() const { return given_.scene.budget.any(); }
    double allowed() const { return allowed_; }  ///< s, of the newest frame
    Sacrifice now() const;
    void set(double amount) { amount_ = applied_ = amount; }

private:
    SceneFile given_;
    int frames_;
    double amount_ = 0, applied_ = 0, allowed_ = 0;
};

/// The columns of budget.csv, and a row: what the frame took and was allowed, what was given up, and what that did to what can be measured.
std::string budget_header();
struct BudgetRow {
    int frame = 0;
    double time = 0, seconds = 0, allowed = 0;
    Sacrifice given_up;
    double largest_residual = 0;  ///< relative, that a solve of the frame ended with
    long unconverged = 0;         ///< solves of the frame
    double density_error_mean = 0, density_error_max = 0;
};
std::string budget_row(const BudgetRow& row);

}  // namespace whorl
