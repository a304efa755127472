// Flies the graph that was built for this board once, and prints facts of the run as JSON.
//
// Exit status: 0 the run ended, whatever became of the vehicle; 1 a file could not be written
// whole; 2 a wrong argument, or a file that cannot be opened.
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "devices.hpp"
#include "flight.hpp"
#include "links_of_flight.hpp"
#include "lockstep.hpp"
#include "stator/host.hpp"
#include "stator/recording.hpp"
#include "stator/start_options.hpp"
#include "stator/virtual.hpp"
#include "world/ending.hpp"
#include "world/flight_facts.hpp"
#include "world/key_file.hpp"
#include "world/options.hpp"
#include "world/vehicle_text.hpp"
#include "world_vehicle.hpp"

namespace {

using namespace stator;

// Most time that each preemption point takes with `--times random`. The quad passes 138 of them in
// a millisecond, so the machine is busy for 40 % of the time, and jobs overlap.
constexpr std::uint32_t kMaxRandomTime_us = 6;

// Of processor time; an activation of a node takes microseconds.
constexpr unsigned kEndlessStep_s = 5;

struct Run {
    double wall_s = 0.0;
    std::uint64_t activations = 0;
    std::uint64_t lost_samples = 0;
    RecordingCounts recording;
};

[[nodiscard]] bool open(const char* path, std::FILE*& file, const char* mode = "wb") {
    if (path == nullptr) return true;
    file = std::fopen(path, mode);
    if (file != nullptr) return true;
    std::fprintf(stderr, "error: cannot open '%s': %s\n", path, std::strerror(errno));
    return false;
}

// A full disk, a file at its size limit and a pipe that nobody reads cost the log, not the flight:
// the write fails, as it does without these signals.
void fly_on_without_log() {
    std::signal(SIGXFSZ, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
}

// `reason`: of the first write that failed; 0 if there is none, or it is not known.
[[nodiscard]] bool close(const char* path, std::FILE* file, bool is_whole, int reason = 0) {
    if (file == nullptr) return true;
    if (std::fclose(file) != 0 && reason == 0) reason = errno;
    if (is_whole && reason == 0) return true;
    std::fprintf(stderr, "error: cannot write all data to '%s'%s%s\n", path,
                 reason == 0 ? "" : ": ", reason == 0 ? "" : std::strerror(reason));
    return false;
}

mav::SharedKey signing_key;

// The lines with MAVLink. False after one line that says what is wrong.
[[nodiscard]] bool open_mavlink(const world::Options& options) {
    const std::array lines{&board::telem1, &board::telem2};
    for (auto* const line : lines) line->use(signing_key);
    board::nonvolatile0.key = &signing_key;
    if (options.signing_key != nullptr && !world::read_key(options.signing_key, signing_key)) {
        return false;
    }
    for (unsigned i = 0; i < options.mavlink_count; ++i) {
        const std::string wrong = lines[i]->open(options.mavlink[i]);
        if (wrong.empty()) continue;
        std::fprintf(stderr, "error: --mavlink '%s': %s\n", options.mavlink[i], wrong.c_str());
        return false;
    }
    return true;
}

// False after one line that says what is wrong.
[[nodiscard]] bool connect(board::Outside& outside, const char* place) {
    const std::string wrong = outside.connect(place);
    if (wrong.empty()) return true;
    std::fprintf(stderr, "error: --hil '%s': %s\n", place, wrong.c_str());
    return false;
}

constexpr std::uint64_t kSlice_us = 10'000;

// Flies slice by slice; `pause` comes before each of them.
template <class Pause>
void run_in_slices(std::uint64_t duration_us, Pause pause) {
    const auto is_over = [] { return board::is_over() || board::system0.restarts; };
    for (std::uint64_t now_us = 0; now_us < duration_us && !is_over();) {
        pause();
        now_us = std::min(now_us + kSlice_us, duration_us);
        run_until(now_us);
    }
}

// Not faster than real time times the speed. Only the host's clock waits; the flight is the same.
// What a busy machine was late is not made up for, as the vehicle's clock would then jump for who
// talks to it.
void run_paced(const world::Options& options) {
    using Clock = std::chrono::steady_clock;
    constexpr std::chrono::milliseconds kMostLate{50};
    const std::chrono::duration<double> slice(static_cast<double>(kSlice_us) * 1e-6 /
                                              options.speed);
    auto due = Clock::now();
    run_in_slices(options.duration_us, [&] {
        std::this_thread::sleep_until(due);
        due = std::max(due, Clock::now() - kMostLate) +
              std::chrono::duration_cast<Clock::duration>(slice);
    });
}

// The other program sees all that a slice made before the next one begins.
void run_in_lockstep(const world::Options& options, board::Lockstep& other) {
    bool is_first = true;
    run_in_slices(options.duration_us, [&] {
        if (!is_first) other.tell_done();
        is_first = false;
        if (other.is_open()) other.wait();
    });
}

// Of each task, from "TASK=MICROSECONDS,...". False if one lacks its budget.
[[nodiscard]] bool read_budgets(std::string_view text, std::vector<std::uint32_t>& budgets) {
    for (unsigned i = 0; i < program.task_count; ++i) {
        const std::string key = "," + std::string(program.tasks[i].name) + "=";
        const std::string list = "," + std::string(text);
        const std::size_t at = list.find(key);
        if (at == std::string::npos) {
            std::fprintf(stderr, "error: --budgets: missing budget of '%s'\n",
                         program.tasks[i].name);
            return false;
        }
        const char* const digits = list.c_str() + at + key.size();
        budgets.push_back(static_cast<std::uint32_t>(std::strtoul(digits, nullptr, 10)));
    }
    return true;
}

Run run(const world::Options& options, const std::vector<std::uint32_t>& budgets,
        board::Lockstep& lockstep) {
    // The host's clock is for the report only; nothing that is logged may depend on it.
    const auto begin = std::chrono::steady_clock::now();
    start();
    if (options.random_times) use_random_times({options.conditions.seed, kMaxRandomTime_us});
    if (!budgets.empty()) use_budgets(budgets);
    if (lockstep.is_open()) {
        run_in_lockstep(options, lockstep);
    } else if (options.speed > 0.0) {
        run_paced(options);
    } else {
        run_until(options.duration_us);
    }
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    Run result{.wall_s = wall.count(), .recording = recording_counts()};
    for (unsigned i = 0; i < program.task_count; ++i) {
        result.activations += program.tasks[i].counters->activations;
        result.lost_samples += program.tasks[i].counters->lost_samples;
    }
    return result;
}

// False: the graph has no such node.
[[nodiscard]] bool silence_nodes(const world::Faults& faults) {
    for (const world::Fault& fault : faults) {
        if (fault.kind != world::FaultKind::kHang) continue;
        if (silence(fault.part.data(), fault.from_us, fault.until_us)) continue;
        std::fprintf(stderr, "error: --fail: unknown node '%s'\n", fault.part.data());
        return false;
    }
    return true;
}

// With the keys of a flight in our own world.
void print_outside_facts(const board::Outside& outside, double wall_s) {
    const char* ended = outside.is_over() ? "motors_stopped" : "time_limit";
    if (board::system0.restarts) ended = "restart";
    if (!outside.problem().empty()) ended = "problem";
    std::fprintf(host::facts, "\"ended\": \"%s\", \"simulated_s\": %0.6F, \"wall_s\": %0.6F, ",
                 ended, static_cast<double>(outside.time_us()) * 1e-6, wall_s);
    std::fprintf(host::facts, "\"problem\": \"%s\", \"motors_have_run\": %s, ",
                 outside.problem().c_str(), outside.motors_have_run() ? "true" : "false");
    std::fprintf(host::facts, "\"motors_are_stopped\": %s",
                 outside.motors_are_stopped() ? "true" : "false");
}

// One line of JSON.
void print(const Run& run, const board::Outside* outside) {
    std::fprintf(host::facts, "{\"activations\": %llu, \"lost_samples\": %llu, ",
                 static_cast<unsigned long long>(run.activations),
                 static_cast<unsigned long long>(run.lost_samples));
    std::fprintf(host::facts, "\"preemptions\": %llu, \"unrecorded_activations\": %llu, ",
                 static_cast<unsigned long long>(run.recording.preemptions),
                 static_cast<unsigned long long>(run.recording.lost));
    const char* const refused = refused_publications.newest.load();
    std::fprintf(host::facts, "\"refused_publications\": %u, \"refused_output\": \"%s\", ",
                 refused_publications.count.load(), refused == nullptr ? "" : refused);
    std::fprintf(
        host::facts, "\"missed_life_signs\": %llu, ",
        static_cast<unsigned long long>(missed_life_signs(program.watched, program.watched_count)));
    if (outside != nullptr) {
        print_outside_facts(*outside, run.wall_s);
    } else {
        world::print_flight_facts(host::facts, board::world(), run.wall_s, board::system0.restarts);
    }
    std::fputs("}\n", host::facts);
}

}  // namespace

int main(int count, char** arguments) {
    world::Options options{.vehicle = world::vehicle_of(board::kWorldVehicle)};
    std::FILE* truth = nullptr;
    host::begin([] { return executor.now_us; });
    host::watch_steps(kEndlessStep_s);
    fly_on_without_log();
    if (!take_start_values(count, arguments)) return 2;
    if (!world::parse(count, arguments, options)) return 2;
    if ((options.random_times || options.budgets != nullptr) && !kHasPreemptionPoints) {
        std::fputs("error: --times needs a build with preemption points\n", stderr);
        return 2;
    }
    std::vector<std::uint32_t> budgets;
    if (options.budgets != nullptr && !read_budgets(options.budgets, budgets)) return 2;
    if (!open(options.log, board::log_storage.file) || !open(options.truth, truth)) return 2;
    board::log_storage.offer(options.log);
    std::FILE* mission = nullptr;
    if (!open(options.mission, mission, "r+b")) return 2;
    if (!open_mavlink(options)) return 2;
    world::end_by_signals();
    board::Lockstep lockstep;
    if (options.lockstep != nullptr) {
        const std::string wrong = lockstep.connect(options.lockstep);
        if (!wrong.empty()) {
            std::fprintf(stderr, "error: --lockstep '%s': %s\n", options.lockstep, wrong.c_str());
            return 2;
        }
    }
    if (!silence_nodes(options.conditions.faults)) return 2;
    if (!board::prepare_links(options.conditions)) return 2;
    std::optional<board::Outside> outside;
    if (options.hil == nullptr) {
        board::prepare(options.conditions, options.vehicle, mission, truth);
    } else {
        outside.emplace(options.conditions, options.vehicle);
        if (!connect(*outside, options.hil)) return 2;
        board::prepare(*outside, mission);
    }
    print(run(options, budgets, lockstep), outside ? &*outside : nullptr);
    const bool log_written = close(options.log, board::log_storage.file,
                                   board::log_storage.errors == 0, board::log_storage.reason);
    const bool truth_written = close(options.truth, truth, board::truth_is_whole());
    return log_written && truth_written ? 0 : 1;
}
