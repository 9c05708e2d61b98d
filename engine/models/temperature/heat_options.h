#pragma once
/// Heat in the fluid: material, air and solids. All temperatures are in K.
#include <algorithm>
#include <array>
#include <optional>

#include "engine/math/expression.h"

namespace whorl {

/// Specific enthalpy of a material that melts over a range of temperatures (the enthalpy method, Voller and Prakash 1987,
/// doi:10.1016/0017-9310(87)90317-6):
///   h(T) = c T + L f(T),   f = (T - solidus)/(liquidus - solidus), limited to [0, 1]
struct HeatLaw {
    double capacity = 0, latent = 0;   ///< c [J/(kg K)], L [J/kg]
    double solidus = 0, liquidus = 0;  ///< K; not used if L is 0
    double enthalpy(double T) const {  ///< J/kg
        return capacity * T + (latent > 0 ? latent * std::clamp((T - solidus) / (liquidus - solidus), 0.0, 1.0) : 0);
    }
    /// The temperature with the specific enthalpy h [K].
    double temperature(double h) const {
        if (!(latent > 0) || h <= capacity * solidus) return h / capacity;
        if (h >= capacity * liquidus + latent) return (h - latent) / capacity;
        return solidus + (h - capacity * solidus) / (capacity + latent / (liquidus - solidus));
    }
    /// dh/dT [J/(kg K)]
    double slope(double T) const { return capacity + (latent > 0 && T >= solidus && T < liquidus ? latent / (liquidus - solidus) : 0); }
};

struct HeatOptions {
    double conductivity = 0.6;                  ///< W/(m K)
    double capacity = 4180;                     ///< J/(kg K)
    double latent_heat = 0;                     ///< J/kg
    std::array<double, 2> melting_range{0, 0};  ///< solidus and liquidus [K]
    double air = 293.15;                        ///< temperature of air and surroundings, and of fluid that names none [K]
    double film = 0;                            ///< film coefficient between fluid and air [W/(m^2 K)]; 0: no exchange
    double emissivity = 0;                      ///< of the free surface
    HeatLaw law() const { return {capacity, latent_heat, melting_range[0], melting_range[1]}; }
    bool meets_air() const { return film > 0 || emissivity > 0; }
};

/// Exchange of heat with a solid. Without a temperature or a flux the solid is adiabatic.
struct SolidHeat {
    std::optional<Expression> temperature;  ///< K, of t, x, y, z
    std::optional<double> film;             ///< W/(m^2 K), between solid and fluid; empty: perfect contact
    std::optional<Expression> flux;         ///< W/m^2 into the fluid, of t, x, y, z
    bool acts() const { return temperature || flux; }
};

}  // namespace whorl
