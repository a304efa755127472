// The plant of a vehicle as text: what a test in Python asks, line by line. Answers are numbers on
// a line.
//
//   wing U V W P Q R DENSITY D1..D8            forces and torques of the wing
//   propeller U V W P Q R DENSITY SPEED WATTS  those of the first propeller, and its acceleration
//   start X Y Z VX VY VZ QW QX QY QZ P Q R SPEED   a plant in this state, its servos without lag
//   air DENSITY
//   servos D1..D8 / throttle T                 commands
//   run STEP COUNT                             its state, and the deflections
//   world OPTIONS                              a flight's world, as the flight program's options
//   until SECONDS                              its state, specific force, and what is measured
#include <array>
#include <cstdio>
#include <iostream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "world/options.hpp"
#include "world/pitot.hpp"
#include "world/world.hpp"

namespace stator::world {
namespace {

void print(std::initializer_list<double> values) {
    for (const double value : values) std::printf("%.17g ", value);
}
void print(const Vector3& v) {
    print({v.x(), v.y(), v.z()});
}
void print(const Wrench& wrench) {
    print(wrench.force_B);
    print(wrench.torque_B);
}
void print(const Plant& plant) {
    const VehicleState& state = plant.state();
    print(state.position_N);
    print(state.velocity_N);
    print({state.q_NB.w(), state.q_NB.x(), state.q_NB.y(), state.q_NB.z()});
    print(state.rate_B);
    print({state.propeller_speeds[0]});
    for (const double deflection : plant.deflections()) print({deflection});
}

Vector3 read3(std::istream& in) {
    Vector3 result;
    for (double& component : result) in >> component;
    return result;
}

class Bench {
  public:
    explicit Bench(const Vehicle& vehicle) : vehicle_(vehicle) {}

    // False: an unknown word.
    bool answer(const std::string& line) {
        std::istringstream in(line);
        std::string word;
        in >> word;
        if (word == "wing") return wing(in);
        if (word == "propeller") return propeller(in);
        if (word == "start") return start(in);
        if (word == "air") in >> influence_.air_density;
        if (word == "servos" || word == "throttle") return command(word, in);
        if (word == "run") return run(in);
        if (word == "world") return make_world(in);
        if (word == "until") return until(in);
        return word == "air";
    }

  private:
    bool wing(std::istream& in) {
        const Vector3 velocity_B = read3(in);
        const Vector3 rate_B = read3(in);
        double density = 0.0;
        in >> density;
        Deflections deflections{};
        for (double& deflection : deflections) in >> deflection;
        print(wing_wrench(vehicle_.airframe.wing, deflections, velocity_B, rate_B, density));
        return true;
    }

    bool propeller(std::istream& in) {
        PropellerInput input{.velocity_B = read3(in)};
        input.rate_B = read3(in);
        in >> input.air_density >> input.speed >> input.shaft_power;
        const PropellerOutput output = turn(vehicle_.airframe.propellers[0], input);
        print(output.wrench);
        print({output.speed_rate});
        return true;
    }

    bool start(std::istream& in) {
        VehicleState state;
        state.position_N = read3(in);
        state.velocity_N = read3(in);
        in >> state.q_NB.w() >> state.q_NB.x() >> state.q_NB.y() >> state.q_NB.z();
        state.rate_B = read3(in);
        in >> state.propeller_speeds[0];
        Airframe airframe = vehicle_.airframe;
        for (Surface& surface : airframe.wing.surfaces) {
            surface.time_constant = 0.0;
            surface.rate = 1e9;
        }
        plant_.emplace(airframe, state);
        return true;
    }

    bool command(const std::string& word, std::istream& in) {
        ServoControls servos{};
        Controls motors{};
        if (word == "servos") {
            for (float& control : servos) in >> control;
        } else {
            in >> motors[vehicle_.airframe.rotor_count()];
        }
        if (world_) {
            word == "servos" ? world_->command_servos(world_->time_us(), servos)
                             : world_->command_motors(world_->time_us(), motors);
        } else {
            word == "servos" ? plant_->command_servos(servos) : plant_->command(motors);
        }
        return true;
    }

    bool run(std::istream& in) {
        double step = 0.0;
        int count = 0;
        in >> step >> count;
        plant_->set_influence(influence_);
        for (int i = 0; i < count; ++i) plant_->step(step);
        print(*plant_);
        return true;
    }

    bool make_world(std::istream& in) {
        std::vector<std::string> words{"bench"};
        for (std::string word; in >> word;) words.push_back(word);
        std::vector<const char*> arguments;
        for (const std::string& word : words) arguments.push_back(word.c_str());
        Options options{.vehicle = vehicle_};
        arguments.push_back(nullptr);
        if (!parse(static_cast<int>(words.size()), arguments.data(), options)) return false;
        world_.emplace(options.conditions, options.vehicle);
        pitot_.emplace(PitotParameters{}, options.conditions.earth, options.conditions.seed);
        return true;
    }

    bool until(std::istream& in) {
        double seconds = 0.0;
        in >> seconds;
        PitotSample sample{};
        while (static_cast<double>(world_->next_event_us()) <= seconds * 1e6) {
            world_->move_to_next_event();
            if (world_->time_us() % PitotParameters{}.period_us == 0) {
                sample = pitot_->measure(world_->plant(), world_->conditions().faults);
            }
        }
        print(world_->plant());
        print(world_->plant().specific_force_B());
        print(world_->influence().wind_N);
        print({static_cast<double>(sample.pressure), world_->influence().air_density,
               world_->plant().is_on_ground() ? 1.0 : 0.0, world_->battery().remaining()});
        return true;
    }

    Vehicle vehicle_;
    Influence influence_{};
    std::optional<Plant> plant_;
    std::optional<World> world_;
    std::optional<Pitot> pitot_;
};

}  // namespace
}  // namespace stator::world

int main(int count, char** arguments) {
    using namespace stator::world;
    Options options;
    if (!parse(count, arguments, options)) return 2;
    Bench bench(options.vehicle);
    for (std::string line; std::getline(std::cin, line);) {
        if (!bench.answer(line)) {
            std::fprintf(stderr, "error: cannot answer '%s'\n", line.c_str());
            return 2;
        }
        std::puts("");
    }
    return 0;
}
