// The simulated world as the simulator of an autopilot that flies by HIL messages, in lockstep if
// the autopilot can; prints facts of the flight as JSON: docs/hil.md.
//
// Takes the options of a simulated flight; --log, --mission, --mavlink, --pilot and --times mean
// nothing here. Exit status: 0 the flight ended; 1 a file could not be written whole; 2 a wrong
// argument, or a file or port that cannot be opened.
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <thread>

#include "hil/link.hpp"
#include "sensors.hpp"
#include "world/ending.hpp"
#include "world/flight_facts.hpp"
#include "world/options.hpp"
#include "world/truth.hpp"
#include "world/vehicle_text.hpp"
#include "world/world.hpp"
#include "world_vehicle.hpp"

namespace {

using namespace stator;
using std::chrono::milliseconds;

// Each 4 ms, as other simulators do.
constexpr std::uint64_t kPeriod_us = 4000;
// An autopilot that is still starting gets the next message then; one that has answered in lockstep
// is waited for.
constexpr milliseconds kStarts{5000};
constexpr milliseconds kHangs{60'000};

class Simulator {
  public:
    Simulator(const world::Options& options, std::FILE* truth)
        : world_(options.conditions, options.vehicle),
          sensors_(world_),
          options_(options),
          truth_(truth),
          truth_is_whole_(truth == nullptr || world::write_truth_head(truth, world_)) {}

    // False after one line that says what is wrong.
    [[nodiscard]] bool wait_for_autopilot() {
        const std::string wrong = link_.listen(options_.hil);
        if (wrong.empty()) return true;
        std::fprintf(stderr, "error: --hil '%s': %s\n", options_.hil, wrong.c_str());
        return false;
    }

    void fly() {
        begin_ = std::chrono::steady_clock::now();
        while (!is_over()) {
            move();
            send();
            hear();
            keep_pace();
        }
        if (!link_.is_open()) end_alone();
    }

    void print(double wall_s) const {
        std::fputs("{", stdout);
        world::print_flight_facts(stdout, world_, wall_s, false);
        std::printf(", \"problem\": \"%s\"}\n", problem_);
    }
    bool truth_is_whole() const { return truth_is_whole_; }

  private:
    bool is_over() const {
        return world_.is_over() || world_.next_event_us() > options_.duration_us ||
               !link_.is_open() || *problem_ != '\0' || world::ending_signal.load() != 0;
    }

    // An autopilot that goes away after the landing has ended the flight; the motors stand still.
    void end_alone() {
        if (!world_.plant().is_on_ground())
            problem_ = "the autopilot closed the connection in flight";
        if (!world_.watch().take_off_us())
            problem_ = "the autopilot closed the connection before the take-off";
        world::Controls stopped;
        stopped.fill(math::canonical_nan<float>());
        world_.command_motors(world_.time_us(), stopped);
        while (*problem_ == '\0' && !world_.is_over()) move();
    }

    void move() {
        do {
            world_.move_to_next_event();
            sensors_.measure(world_, samples_);
            record_truth();
        } while (world_.time_us() % kPeriod_us != 0);
    }

    void record_truth() {
        if (truth_ == nullptr || world_.time_us() % world::kTruthPeriod_us != 0) return;
        truth_is_whole_ = world::write_truth(truth_, world_) && truth_is_whole_;
    }

    // What the sensors have measured since the last time. A fix first: in lockstep the autopilot
    // goes on at HIL_SENSOR.
    void send() {
        if (samples_.gnss0.is_new != 0) link_.send(fix_of(samples_.gnss0.sample));
        link_.send(sensors_of(samples_));
        samples_ = {};
    }

    template <class Samples>
    mav::HilSensor sensors_of(const Samples& samples) const;
    template <class Fix>
    static mav::HilGps fix_of(const Fix& fix);

    // The answer; of an autopilot without lockstep, what has come.
    void hear() {
        const bool waits = is_lockstep_ || !has_answered_;
        const milliseconds most = is_lockstep_ ? kHangs : is_starting_ ? kStarts : milliseconds{4};
        const auto end = std::chrono::steady_clock::now() + most;
        for (bool is_heard = false; !is_heard;) {
            const auto left =
                std::chrono::duration_cast<milliseconds>(end - std::chrono::steady_clock::now());
            const auto frame =
                link_.next(waits ? std::max(left, milliseconds{0}) : milliseconds{0});
            if (!frame) break;
            if (frame->id != mav::HilActuatorControls::kId) continue;
            obey(mav::decode<mav::HilActuatorControls>(frame->payload));
            is_heard = is_lockstep_ || waits;
            has_answered_ = true;
        }
        is_starting_ = false;
        if (is_lockstep_ && std::chrono::steady_clock::now() >= end) {
            problem_ = "the autopilot has not answered for 60 s";
        }
    }

    void obey(const mav::HilActuatorControls& controls) {
        is_lockstep_ = (controls.flags & hil::kLockstep) != 0;
        const bool is_armed = (controls.mode & mav::mav_mode_flag::kSafetyArmed) != 0;
        world::Controls motors;
        for (unsigned i = 0; i < motors.size(); ++i) {
            motors[i] = is_armed ? controls.controls[i] : math::canonical_nan<float>();
        }
        world_.command_motors(world_.time_us(), motors);
    }

    // An autopilot without lockstep lives in real time.
    void keep_pace() const {
        const bool is_free = is_lockstep_ && options_.speed <= 0.0;
        if (is_free) return;
        const double speed = options_.speed > 0.0 ? options_.speed : 1.0;
        const std::chrono::duration<double> due(static_cast<double>(world_.time_us()) * 1e-6 /
                                                speed);
        std::this_thread::sleep_until(
            begin_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(due));
    }

    world::World world_;
    board::Sensors sensors_;
    board::Samples samples_{};
    const world::Options& options_;
    std::FILE* truth_;
    bool truth_is_whole_;
    hil::Link link_{{.system = 1, .component = 51}};
    bool is_starting_ = true;
    bool has_answered_ = false;
    bool is_lockstep_ = false;
    const char* problem_ = "";
    std::chrono::steady_clock::time_point begin_{};
};

// Every message has accelerations and rates.
template <class Samples>
mav::HilSensor Simulator::sensors_of(const Samples& samples) const {
    const auto& imu = samples.imu0.sample;
    mav::HilSensor message{.time_usec = world_.time_us()};
    if (samples.imu0.is_new != 0) {
        message.fields_updated |= hil::kAccel | hil::kGyro;
        message.xacc = imu.accel_B[0];
        message.yacc = imu.accel_B[1];
        message.zacc = imu.accel_B[2];
        message.xgyro = imu.gyro_B[0];
        message.ygyro = imu.gyro_B[1];
        message.zgyro = imu.gyro_B[2];
    }
    if (samples.mag0.is_new != 0) {
        const auto& field = samples.mag0.sample.field_B_gauss;
        message.fields_updated |= hil::kMag;
        message.xmag = field[0];
        message.ymag = field[1];
        message.zmag = field[2];
    }
    if (samples.baro0.is_new != 0) {
        // ISO 2533, the other way round.
        constexpr double kSea = 101325.0;
        constexpr double kPerHeight = 0.0065 / 288.15;
        const double pressure = static_cast<double>(samples.baro0.sample.pressure);
        const double height = (1.0 - math::pow(pressure / kSea, 1.0 / 5.255880)) / kPerHeight;
        message.fields_updated |= hil::kBaro;
        message.abs_pressure = 0.01F * samples.baro0.sample.pressure;
        message.pressure_alt = static_cast<float>(height);
        message.temperature = samples.baro0.sample.temperature_degc;
    }
    return message;
}

template <class Fix>
mav::HilGps Simulator::fix_of(const Fix& fix) {
    const auto centimetres = [](float metres) {
        return math::saturate<std::int16_t>(math::round(100.0F * metres));
    };
    const auto scaled = [](double value, double steps) {
        return math::saturate<std::int32_t>(math::round(value * steps));
    };
    const auto& v = fix.velocity_N;
    const float speed = math::sqrt(v[0] * v[0] + v[1] * v[1]);
    constexpr double kCentidegrees = 18000.0 / math::kPi<double>;
    constexpr int kTurn = 36000;
    const double course = kCentidegrees * static_cast<double>(math::atan2(v[1], v[0]));
    const int course_cdeg = math::saturate<std::int32_t>(math::round(course));
    constexpr std::uint32_t kSatellitesOfFix = 4;
    return {.time_usec = fix.timestamp_sample,
            .lat = scaled(fix.latitude_deg, 1e7),
            .lon = scaled(fix.longitude_deg, 1e7),
            .alt = scaled(fix.altitude_msl_m, 1e3),
            .eph = static_cast<std::uint16_t>(centimetres(fix.horizontal_error)),
            .epv = static_cast<std::uint16_t>(centimetres(fix.vertical_error)),
            .vel = static_cast<std::uint16_t>(centimetres(speed)),
            .vn = centimetres(v[0]),
            .ve = centimetres(v[1]),
            .vd = centimetres(v[2]),
            .cog = static_cast<std::uint16_t>((course_cdeg + kTurn) % kTurn),
            .fix_type = static_cast<std::uint8_t>(fix.satellites >= kSatellitesOfFix ? 3 : 0),
            .satellites_visible = static_cast<std::uint8_t>(fix.satellites)};
}

}  // namespace

int main(int count, char** arguments) {
    world::Options options{.vehicle = world::vehicle_of(board::kWorldVehicle)};
    if (!world::parse(count, arguments, options)) return 2;
    world::end_by_signals();
    std::FILE* truth = options.truth == nullptr ? nullptr : std::fopen(options.truth, "wb");
    if (options.truth != nullptr && truth == nullptr) {
        std::fprintf(stderr, "error: cannot open '%s': %s\n", options.truth, std::strerror(errno));
        return 2;
    }
    Simulator simulator(options, truth);
    if (options.hil == nullptr || !simulator.wait_for_autopilot()) return 2;
    const auto begin = std::chrono::steady_clock::now();
    simulator.fly();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    simulator.print(wall.count());
    const bool is_whole =
        truth == nullptr || (std::fclose(truth) == 0 && simulator.truth_is_whole());
    return is_whole ? 0 : 1;
}
