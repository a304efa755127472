// Where on Earth the simulated world lies, and what is there: geodesy, air, magnetic field.
#pragma once

#include "stator/rotation.hpp"

namespace stator::world {

using Vector3 = math::Vector3<double>;

struct Geodetic {
    double latitude_deg;
    double longitude_deg;
    double altitude_msl;        // m
    double altitude_ellipsoid;  // m
};

// A field near Zurich, where PX4's simulations start, too.
struct Earth {
    double latitude_deg = 47.397742;
    double longitude_deg = 8.545594;
    double altitude_msl = 488.0;     // m, of the origin of N
    double geoid = 47.6;             // m, of mean sea level above the ellipsoid; EGM96
    double sea_pressure = 101325.0;  // Pa, ISO 2533
    // World Magnetic Model 2020 for the beginning of 2024, rounded.
    double field_gauss = 0.484;
    double declination_deg = 3.3;
    double inclination_deg = 63.4;

    // WGS 84; good to a millimetre within a kilometre of the origin.
    Geodetic geodetic(const Vector3& position_N) const;
    // Static pressure in Pa, and temperature in degC, of the standard atmosphere, ISO 2533.
    double pressure(double height) const;
    double temperature_degc(double height) const;
    double density(double height) const;  // kg/m^3, of the same atmosphere
    Vector3 magnetic_field_N() const;     // gauss
};

}  // namespace stator::world
