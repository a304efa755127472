// A Pixhawk for the image in the emulator: the model of its chip, the parts on its board, and the
// vehicle that it is fixed to. Prints facts of the run as JSON.
//   pixhawk_server SOCKET [--line NAME FILE]... [--task ADDRESS]... [--log-errors ADDRESS] [--seed
//   N and other options of a simulated flight]
// A line's file gets the bytes that the firmware sends there. Addresses are hexadecimal: of the
// counters of a task, and of the number of log blocks that found no room. --times and --mission
// mean nothing here. A signal ends a flight in order. Exit status: 0 the flight ended; 1 the
// firmware broke a rule of the chip, the emulator went away, or a file could not be written whole;
// 2 a wrong argument, or a file that cannot be opened.
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <list>
#include <string_view>
#include <vector>

#include "chip/chip.hpp"
#include "chip/usart.hpp"
#include "emulator.hpp"
#include "pixhawk.hpp"
#include "stator/task_counters.hpp"
#include "world/ending.hpp"
#include "world/flight_facts.hpp"
#include "world/options.hpp"
#include "world/truth.hpp"
#include "world/vehicle_text.hpp"
#include "world_vehicle.hpp"

namespace {

using namespace stator;

constexpr uint32_t kCrystal_hz = 24'000'000;
constexpr const char* kLogLine = "UART7";

struct Arguments {
    const char* socket = nullptr;
    struct Line {
        const char* name;
        const char* file;
    };
    std::vector<Line> lines;
    std::vector<uint32_t> tasks;  // addresses of their counters
    uint32_t log_errors = 0;      // address of their number
    world::Options flight{.vehicle = world::vehicle_of(board::kWorldVehicle)};
};

uint32_t address_in(const char* text) {
    return static_cast<uint32_t>(std::strtoul(text, nullptr, 16));
}

// False after one line that says what is wrong.
[[nodiscard]] bool parse(int count, char** words, Arguments& arguments) {
    std::vector<const char*> others{words[0]};
    if (count > 1) arguments.socket = words[1];
    for (int i = 2; i < count; ++i) {
        const std::string_view word = words[i];
        if (word == "--line" && i + 2 < count) {
            arguments.lines.push_back({words[i + 1], words[i + 2]});
            i += 2;
        } else if (word == "--task" && i + 1 < count) {
            arguments.tasks.push_back(address_in(words[++i]));
        } else if (word == "--log-errors" && i + 1 < count) {
            arguments.log_errors = address_in(words[++i]);
        } else {
            others.push_back(words[i]);
        }
    }
    const auto rest = static_cast<int>(others.size());
    others.push_back(nullptr);
    if (arguments.socket != nullptr) return world::parse(rest, others.data(), arguments.flight);
    std::fputs("error: missing the socket\n", stderr);
    return false;
}

// What the firmware sends on a line.
class LineFiles {
  public:
    // False after one line that says what is wrong.
    [[nodiscard]] bool add(chip::Chip& chip, const char* name, const char* path) {
        std::ofstream& file = files_.emplace_back(path, std::ios::binary);
        chip.usart(name).watch([&file](uint8_t byte) { file.put(static_cast<char>(byte)); });
        if (file) return true;
        std::fprintf(stderr, "error: cannot open '%s'\n", path);
        return false;
    }
    bool finish() {
        bool is_whole = true;
        for (std::ofstream& file : files_) {
            file.close();
            is_whole = is_whole && !file.fail();
        }
        return is_whole;
    }

  private:
    std::list<std::ofstream> files_;
};

unsigned long long wide(uint64_t value) {
    return value;
}

// What the firmware counted, as a debugger reads it.
struct Counted {
    std::vector<TaskCounters> tasks;
    uint32_t log_errors = 0;
};

template <class T>
T read_at(chip::Emulator& emulator, uint32_t address) {
    std::array<uint8_t, sizeof(T)> bytes{};
    emulator.fetch(address, bytes);
    T value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
}

Counted read_counted(chip::Emulator& emulator, const Arguments& arguments) {
    Counted counted;
    for (const uint32_t address : arguments.tasks) {
        counted.tasks.push_back(read_at<TaskCounters>(emulator, address));
    }
    if (arguments.log_errors != 0) {
        counted.log_errors = read_at<uint32_t>(emulator, arguments.log_errors);
    }
    return counted;
}

// One line of JSON, with the keys of a simulated flight.
void print(const chip::Chip& chip, const chip::Emulator& emulator, const plant::Pixhawk& pixhawk,
           const Counted& counted, double wall_s) {
    const chip::Mpu6000& imu = pixhawk.imu();
    std::printf("{\"requests\": %llu, \"core_clock_hz\": %u, \"resets\": %u, ",
                wide(emulator.requests()), chip.clocks().core_hz, emulator.resets());
    std::printf("\"imu_samples\": %llu, \"imu_read\": %llu, \"missed_samples\": %llu, ",
                wide(imu.samples()), wide(imu.bursts()), wide(imu.missed()));
    uint64_t activations = 0;
    uint64_t lost_samples = 0;
    std::printf("\"tasks\": [");
    for (const TaskCounters& task : counted.tasks) {
        std::printf("%s[%u, %u, %u]", &task == counted.tasks.data() ? "" : ", ", task.activations,
                    task.most_ticks, task.latest_us);
        activations += task.activations;
        lost_samples += task.lost_samples;
    }
    std::printf("], \"activations\": %llu, \"lost_samples\": %llu, ", wide(activations),
                wide(lost_samples));
    world::print_flight_facts(stdout, pixhawk.world(), wall_s, false);
    std::puts("}");
}

int serve(const Arguments& arguments) {
    const world::Options& flight = arguments.flight;
    chip::Emulator emulator(arguments.socket);
    chip::Chip chip(emulator, kCrystal_hz);
    LineFiles files;
    for (const Arguments::Line& line : arguments.lines) {
        if (!files.add(chip, line.name, line.file)) return 2;
    }
    if (flight.log != nullptr && !files.add(chip, kLogLine, flight.log)) return 2;
    std::FILE* const truth = flight.truth == nullptr ? nullptr : std::fopen(flight.truth, "wb");
    if (flight.truth != nullptr && truth == nullptr) {
        std::fprintf(stderr, "error: cannot open '%s'\n", flight.truth);
        return 2;
    }
    const auto begin = std::chrono::steady_clock::now();
    plant::Pixhawk pixhawk(chip, flight, truth);
    emulator.serve(chip, [&] { return pixhawk.is_over(); });
    Counted counted;
    if (pixhawk.is_over()) {
        counted = read_counted(emulator, arguments);
        emulator.stop();
    }
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    print(chip, emulator, pixhawk, counted, wall.count());
    if (counted.log_errors != 0) {
        std::fprintf(stderr, "error: %u blocks of the log found no room on its line\n",
                     counted.log_errors);
    }
    const bool is_whole = truth == nullptr || (std::fclose(truth) == 0 && pixhawk.truth_is_whole());
    const bool is_good = is_whole && pixhawk.is_over() && counted.log_errors == 0;
    return files.finish() && is_good ? 0 : 1;
}

}  // namespace

int main(int count, char** words) {
    Arguments arguments;
    if (!parse(count, words, arguments)) return 2;
    world::end_by_signals();
    try {
        return serve(arguments);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return 1;
    }
}
