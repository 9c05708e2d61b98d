#pragma once
/// The names that choices have in scene files, plans and run.json.
#include <utility>
#include <vector>

#include "engine/scene/scene.h"

namespace whorl {

template <class E>
using Choices = std::vector<std::pair<E, const char*>>;

inline Choices<PressureModel> choices(PressureModel) {
    using P = PressureModel;
    return {{P::automatic, "auto"}, {P::none, "none"}, {P::wcsph, "wcsph"}, {P::ppe, "ppe"}, {P::coupled, "coupled"}};
}
inline Choices<ViscosityModel> choices(ViscosityModel) {
    using V = ViscosityModel;
    return {{V::automatic, "auto"}, {V::none, "none"},
            {V::xsph, "xsph"},      {V::explicit_laplacian, "explicit"},
            {V::full, "full"},      {V::full_assembled, "full_assembled"}};
}
inline Choices<MicropolarModel> choices(MicropolarModel) {
    using M = MicropolarModel;
    return {{M::none, "none"}, {M::seed, "seed"}, {M::bender, "bender"}, {M::eringen, "eringen"}};
}
inline Choices<BoundaryModel> choices(BoundaryModel) {
    using B = BoundaryModel;
    return {{B::automatic, "auto"}, {B::none, "none"}, {B::akinci, "akinci"}, {B::ppe, "ppe"}};
}
inline Choices<ShiftingModel> choices(ShiftingModel) {
    using S = ShiftingModel;
    return {{S::automatic, "auto"}, {S::none, "none"}, {S::fickian, "fickian"}};
}
inline Choices<Preconditioner> choices(Preconditioner) {
    return {{Preconditioner::automatic, "auto"},
            {Preconditioner::none, "none"},
            {Preconditioner::jacobi, "jacobi"},
            {Preconditioner::multigrid, "multigrid"}};
}
inline Choices<ViscousPreconditioner> choices(ViscousPreconditioner) {
    using P = ViscousPreconditioner;
    return {{P::automatic, "auto"}, {P::none, "none"}, {P::block_jacobi, "block_jacobi"}, {P::two_level, "two_level"}};
}
inline Choices<PressureForm> choices(PressureForm) {
    return {{PressureForm::constraint, "constraint"}, {PressureForm::poisson, "poisson"}};
}
inline Choices<GradientForm> choices(GradientForm) {
    return {{GradientForm::symmetric, "symmetric"}, {GradientForm::difference, "difference"}};
}
inline Choices<LaplacianForm> choices(LaplacianForm) {
    return {{LaplacianForm::brookshaw, "brookshaw"}, {LaplacianForm::monaghan, "monaghan"}, {LaplacianForm::split, "split"}};
}
inline Choices<ExchangeScheme> choices(ExchangeScheme) {
    using E = ExchangeScheme;
    return {{E::automatic, "auto"}, {E::explicit_steps, "explicit"}, {E::implicit, "implicit"}};
}
inline Choices<WallSpin> choices(WallSpin) { return {{WallSpin::solid, "solid"}, {WallSpin::free, "free"}}; }
inline Choices<CurlForm> choices(CurlForm) {
    return {{CurlForm::symmetric, "symmetric"},
            {CurlForm::difference, "difference"},
            {CurlForm::difference_own_density, "difference_own_density"}};
}
inline Choices<Sampling> choices(Sampling) {
    return {{Sampling::lattice, "lattice"}, {Sampling::jittered, "jittered"}, {Sampling::blue_noise, "blue_noise"}};
}
inline Choices<Slip> choices(Slip) { return {{Slip::no, "no"}, {Slip::free, "free"}, {Slip::navier, "navier"}}; }
inline Choices<Profile> choices(Profile) { return {{Profile::plug, "plug"}, {Profile::parabolic, "parabolic"}}; }
inline Choices<ProbeKind> choices(ProbeKind) {
    using P = ProbeKind;
    return {{P::point, "point"}, {P::line, "line"}, {P::region, "region"}, {P::coil, "coil"}};
}
inline Choices<KernelKind> choices(KernelKind) {
    using K = KernelKind;
    return {{K::cubic, "cubic"}, {K::wendland_c2, "wendland_c2"}, {K::wendland_c4, "wendland_c4"}};
}

/// The name of a choice in files: name_of(PressureModel::ppe) is "ppe".
template <class E>
const char* name_of(E value) {
    for (const auto& [v, name] : choices(value))
        if (v == value) return name;
    return "?";
}

}  // namespace whorl
