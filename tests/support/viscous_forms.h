#pragma once
/// Viscous models by name, as stages of a free-standing world.
#include "engine/models/motion/motion.h"
#include "engine/models/viscosity/explicit_viscosity.h"
#include "engine/models/viscosity/full_viscosity.h"
#include "engine/sph/density.h"
#include "tests/support/world.h"

namespace whorl::test {

enum class ViscousForm { brookshaw, monaghan, full };
constexpr ViscousForm viscous_forms[] = {ViscousForm::brookshaw, ViscousForm::monaghan, ViscousForm::full};

inline bool is_implicit(ViscousForm form) { return form == ViscousForm::full; }
inline const char* name_of(ViscousForm form) {
    return form == ViscousForm::brookshaw ? "brookshaw" : form == ViscousForm::monaghan ? "monaghan" : "full";
}

/// Kernel radius over spacing. Forces along the pairs are isotropic if the neighbours' fourth moments are. On a lattice with R = 2 d they
/// make shear 0.70 and stretching 1.45 times as stiff, so they need more neighbours than the other forms.
inline double support_of(ViscousForm form) { return form == ViscousForm::monaghan ? 4 : 2; }

/// Gravity, kick and the viscosity of that form, without motion and without pressure: the exact flow has none to speak of.
inline std::vector<Stage> viscous_step_of(ViscousForm form, Real solid_factor, double tolerance = 1e-5) {
    std::vector<Stage> stages{make_stage("density", "density", Density{solid_factor}), make_stage("gravity", "move", Gravity{})};
    if (!is_implicit(form))
        stages.push_back(
            make_stage("viscosity", "viscosity",
                       ExplicitViscosity{{.laplacian = form == ViscousForm::monaghan ? LaplacianForm::monaghan : LaplacianForm::brookshaw,
                                          .solid_factor = solid_factor}}));
    stages.push_back(make_stage("kick", "move", Kick{}));
    if (is_implicit(form)) {
        ViscosityOptions options;
        options.solid_factor = solid_factor;
        options.limits.tolerance = tolerance;
        stages.push_back(make_stage("viscosity", "viscosity", FullViscosity(options)));
    }
    return stages;
}

}  // namespace whorl::test
