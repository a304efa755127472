// Between latitude and longitude, and metres in a local frame about an origin.
//
// On the ellipsoid of WGS 84, with the radii of curvature at the origin and the convergence of the
// meridians to second order: 10 km from the origin at 60 degrees latitude wrong by under 0.2 m.
#pragma once

#include "stator/scalar.hpp"

namespace stator::math {

struct LatitudeLongitude {
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
};

struct NorthEast {
    double north = 0.0;  // m
    double east = 0.0;   // m
};

// Double, because a degree is 111 km: float would be good to a metre only.
class LocalFrame {
  public:
    LocalFrame() = default;  // at latitude 0, longitude 0
    explicit LocalFrame(const LatitudeLongitude& origin) : origin_(origin) {
        const SinCos<double> latitude = sincos(origin.latitude_deg * kDegree);
        const double w2 = 1.0 - kEccentricity2 * latitude.sin * latitude.sin;
        transverse_ = kEquator / sqrt(w2);
        meridional_ = transverse_ * (1.0 - kEccentricity2) / w2;
        bend_ = 0.5 * transverse_ * latitude.sin * latitude.cos;
    }

    const LatitudeLongitude& origin() const { return origin_; }

    NorthEast to_local(const LatitudeLongitude& point) const {
        const double dlat = (point.latitude_deg - origin_.latitude_deg) * kDegree;
        const double dlon = wrap_pi((point.longitude_deg - origin_.longitude_deg) * kDegree);
        return {meridional_ * dlat + bend_ * dlon * dlon,
                transverse_ * cos(point.latitude_deg * kDegree) * dlon};
    }

    // The inverse, by a fixed number of iterations. Not for the poles.
    LatitudeLongitude from_local(const NorthEast& point) const {
        LatitudeLongitude result = origin_;
        double dlon = 0.0;
        for (int i = 0; i < 4; ++i) {
            const double dlat = (point.north - bend_ * dlon * dlon) / meridional_;
            result.latitude_deg = origin_.latitude_deg + dlat / kDegree;
            dlon = point.east / (transverse_ * cos(result.latitude_deg * kDegree));
        }
        const double longitude = origin_.longitude_deg * kDegree + dlon;
        result.longitude_deg = wrap_pi(longitude) / kDegree;
        return result;
    }

  private:
    static constexpr double kDegree = kPi<double> / 180.0;
    static constexpr double kEquator = 6378137.0;  // m, WGS 84
    static constexpr double kFlattening = 1.0 / 298.257223563;
    static constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);

    LatitudeLongitude origin_;
    double meridional_ = kEquator * (1.0 - kEccentricity2);  // m, radius of curvature northward
    double transverse_ = kEquator;                           // m, eastward
    double bend_ = 0.0;                                      // m per square radian
};

}  // namespace stator::math
