// A simulated pitot tube: the pressure of the air that meets the vehicle, and what hoses and ice
// make of it.
#pragma once

#include "world/earth.hpp"
#include "world/faults.hpp"
#include "world/noise.hpp"
#include "world/plant.hpp"

namespace stator::world {

// A TE MS4525DO of 1 psi behind a plain tube. Its data sheet has steps and the error band of 0.25 %
// of 2 psi; noise, drift and the error of the static port are estimates.
struct PitotParameters {
    std::uint64_t period_us = 10000;
    double noise = 2.0;            // Pa
    double offset = 1.5;           // Pa, what zeroing on the ground leaves; drawn once a flight
    double drift = 1.5;            // Pa; a Gauss-Markov process
    double drift_tau = 300.0;      // s
    double scale = 0.02;           // of the pressure: the static port; drawn once a flight
    double straight = 0.9659;      // cosine of the angle up to which a tube reads all: 15 deg
    double steps = 0.95;           // 1/Pa: 2 psi in 80 % of 14 bits
    double warmer_by_degc = 10.0;  // than the air
};

struct PitotSample {
    float pressure;  // Pa, total less static
    float temperature_degc;
};

class Pitot {
  public:
    Pitot(const PitotParameters& parameters, const Earth& earth, std::uint64_t seed);
    // To be called once each period.
    PitotSample measure(const Plant& plant, const Faults& faults);

  private:
    // What the air does to the two ports.
    struct Ports {
        double ram = 0.0;              // Pa, over the static pressure around
        double static_pressure = 0.0;  // Pa
    };
    Ports ports(const Plant& plant) const;

    PitotParameters parameters_;
    Earth earth_;
    math::Random random_;
    double offset_;
    double scale_;
    GaussMarkov drift_;
    Ports sealed_{};  // as they were when one of them was last open
};

}  // namespace stator::world
