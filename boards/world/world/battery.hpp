// The simulated battery: the more is drawn, and the less is left, the lower its voltage.
//
//   V = n E(s) - R I,   P = V I,   s' = -I / Q      (s: charge left, 1 to 0)
//
// E(s) of a lithium-polymer cell: Chen and Rincon-Mora, Accurate electrical battery model capable
// of predicting runtime and I-V performance, IEEE Trans. Energy Conversion 21(2), 2006.
#pragma once

namespace stator::world {

struct BatteryParameters {
    double cells = 0.0;
    double capacity_c = 1.0;  // coulomb
    double resistance = 1.0;  // ohm, with the wires
};

class Battery {
  public:
    explicit Battery(const BatteryParameters& parameters);

    // `seconds` later, having given so many watts.
    void draw(double power, double seconds);
    // A fault: at most this is left.
    void limit(double remaining);

    double remaining() const { return remaining_; }
    double voltage() const { return voltage_; }
    double current() const { return current_; }
    double discharged_c() const { return (1.0 - remaining_) * parameters_.capacity_c; }

  private:
    BatteryParameters parameters_;
    double remaining_ = 1.0;
    double voltage_;
    double current_ = 0.0;
};

// E(s), V.
double open_circuit_voltage(double remaining);

}  // namespace stator::world
