// The plant of an emulated flight: moves the world of boards/world as far as the firmware's clock
// says, answers with what the sensors saw, and prints facts of the run as JSON.
//
// Takes the options of a simulated flight; --log and --times mean nothing here. Works in the
// current folder. A signal ends a flight in order. Exit status: 0 the firmware ended the flight; 1
// it went away, or a file could not be written whole; 2 a wrong argument, or a file that cannot be
// opened.
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <thread>

#include "../link.hpp"
#include "line.hpp"
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

struct Files {
    std::FILE* from_firmware = nullptr;
    std::FILE* to_firmware = nullptr;
    std::FILE* truth = nullptr;
};

// In the order in which the firmware opens them, as each waits for the other side.
[[nodiscard]] bool open(const char* path, const char* mode, std::FILE*& file) {
    if (path == nullptr) return true;
    file = std::fopen(path, mode);
    if (file != nullptr) return true;
    std::fprintf(stderr, "error: cannot open '%s': %s\n", path, std::strerror(errno));
    return false;
}

using Lines = std::array<plant::Line, link::kLines.size()>;

// False after one line that says what is wrong.
[[nodiscard]] bool open_lines(const world::Options& options, Lines& lines) {
    for (unsigned i = 0; i < options.mavlink_count; ++i) {
        const std::string wrong =
            lines[i].open(options.mavlink[i], link::kLines[i], link::kLine_baud[i]);
        if (wrong.empty()) continue;
        std::fprintf(stderr, "error: --mavlink '%s': %s\n", options.mavlink[i], wrong.c_str());
        return false;
    }
    return true;
}

class Server {
  public:
    Server(const world::Options& options, const Files& files, Lines& lines)
        : world_(options.conditions, options.vehicle),
          sensors_(world_),
          files_(files),
          lines_(lines),
          duration_us_(options.duration_us),
          speed_(options.speed),
          truth_is_whole_(files.truth == nullptr || world::write_truth_head(files.truth, world_)) {}

    // Serves until the firmware has finished. False if it went away before.
    bool run() {
        for (link::ToPlant message;
             std::fread(&message, sizeof message, 1, files_.from_firmware);) {
            switch (message.kind) {
                case link::ToPlant::Kind::kStep:
                    if (!step(message.time_us)) return false;
                    break;
                case link::ToPlant::Kind::kCommand:
                    world_.command_motors(message.time_us, message.control);
                    break;
                case link::ToPlant::Kind::kServos: {
                    world::ServoControls servos;
                    std::copy_n(message.control.begin(), servos.size(), servos.begin());
                    world_.command_servos(message.time_us, servos);
                    break;
                }
                case link::ToPlant::Kind::kFinished:
                    finished_ = message;
                    return true;
            }
        }
        return false;
    }

    const world::World& world() const { return world_; }
    const link::ToPlant& finished() const { return finished_; }
    bool truth_is_whole() const { return truth_is_whole_; }

  private:
    // The emulated clock stands still while the firmware waits for its answer.
    void keep_pace(uint64_t time_us) const {
        if (speed_ <= 0.0) return;
        const std::chrono::duration<double> due(static_cast<double>(time_us) * 1e-6 / speed_);
        std::this_thread::sleep_until(
            begin_ + std::chrono::duration_cast<std::chrono::steady_clock::duration>(due));
    }

    bool step(uint64_t time_us) {
        keep_pace(time_us);
        for (plant::Line& line : lines_) line.move(time_us);
        link::FromPlant answer{};
        while (world_.next_event_us() <= time_us && world_.next_event_us() <= duration_us_) {
            world_.move_to_next_event();
            sensors_.measure(world_, answer.samples);
            record_truth();
        }
        const bool is_over = world_.is_over() || world_.next_event_us() > duration_us_ ||
                             world::ending_signal.load() != 0;
        answer.is_over = is_over ? 1 : 0;
        return std::fwrite(&answer, sizeof answer, 1, files_.to_firmware) == 1 &&
               std::fflush(files_.to_firmware) == 0;
    }

    void record_truth() {
        if (files_.truth == nullptr || world_.time_us() % world::kTruthPeriod_us != 0) {
            return;
        }
        truth_is_whole_ = world::write_truth(files_.truth, world_) && truth_is_whole_;
    }

    world::World world_;
    board::Sensors sensors_;
    Files files_;
    Lines& lines_;
    uint64_t duration_us_;
    double speed_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    link::ToPlant finished_{};
    bool truth_is_whole_;
};

unsigned long long wide(uint64_t value) {
    return value;
}

// One line of JSON, with the keys of a simulated flight.
void print(const Server& server, double wall_s) {
    std::printf("{\"activations\": %llu, \"lost_samples\": %llu, \"missed_samples\": %llu, ",
                wide(server.finished().activations), wide(server.finished().lost_samples),
                wide(server.finished().missed_samples));
    std::printf("\"preemptions\": %llu, \"unrecorded_activations\": %llu, ",
                wide(server.finished().preemptions),
                wide(server.finished().unrecorded_activations));
    std::printf("\"missed_life_signs\": %llu, ", wide(server.finished().missed_life_signs));
    world::print_flight_facts(stdout, server.world(), wall_s, server.finished().restarts != 0);
    std::puts("}");
}

}  // namespace

int main(int count, char** arguments) {
    world::Options options{.vehicle = world::vehicle_of(board::kWorldVehicle)};
    if (!world::parse(count, arguments, options)) return 2;
    world::end_by_signals();
    Files files;
    Lines lines;
    if (!open_lines(options, lines)) return 2;
    if (!open(options.truth, "wb", files.truth) ||
        !open(link::kToPlant, "rb", files.from_firmware) ||
        !open(link::kFromPlant, "wb", files.to_firmware)) {
        return 2;
    }
    const auto begin = std::chrono::steady_clock::now();
    Server server(options, files, lines);
    const bool finished = server.run();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    print(server, wall.count());
    const bool is_whole =
        files.truth == nullptr || (std::fclose(files.truth) == 0 && server.truth_is_whole());
    return finished && is_whole ? 0 : 1;
}
