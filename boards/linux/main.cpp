// Runs the graph that was built for this board in real time, the simulated world beside it, and
// prints facts of the run as JSON.
//
// Exit status: 0 the run ended, whatever became of the vehicle; 1 a file could not be written
// whole, or the graph did not come to rest or has a task that does not end; 2 a wrong argument, a
// file that cannot be opened, or a machine without the threads; 3 the run ended in order for an
// authorised restart request: start it again; 128 + its number: a signal ended the run.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>

#include "devices.hpp"
#include "mission_memory.hpp"
#include "nonvolatile.hpp"
#include "real_world.hpp"
#include "run_options.hpp"
#include "stator/host.hpp"
#include "stator/recording.hpp"
#include "stator/start_options.hpp"
#include "world/flight_facts.hpp"
#include "world/key_file.hpp"
#include "world/options.hpp"
#include "world/vehicle_text.hpp"
#include "world_vehicle.hpp"

namespace {

using namespace stator;

constexpr int kRestart = 3;  // codegen/stator/flight/restarts.py reads it here

board::RealWorld* the_world = nullptr;

// False: it is a file, and another run has it.
bool is_alone(int file) {
    struct stat facts {};
    const bool is_regular = fstat(file, &facts) == 0 && S_ISREG(facts.st_mode);
    return !is_regular || flock(file, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

// A file is emptied once it is this run's alone: two that write one would report the same flight.
[[nodiscard]] bool open(const char* path, std::FILE*& file) {
    if (path == nullptr) return true;
    constexpr mode_t kMode = 0666;
    const int descriptor = ::open(path, O_WRONLY | O_CREAT | O_CLOEXEC, kMode);
    if (descriptor >= 0 && !is_alone(descriptor)) {
        std::fprintf(stderr,
                     "error: another run writes to '%s'\n"
                     "hint: end that run, or use another log: -o LOG\n",
                     path);
        return false;
    }
    file = descriptor < 0 ? nullptr : fdopen(descriptor, "wb");
    // A pipe, for example, has no length and cannot be emptied.
    if (file != nullptr && (ftruncate(descriptor, 0) == 0 || errno == EINVAL)) return true;
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

void connect(board::RealWorld& world) {
    the_world = &world;
    board::system0.restart = stop;
    parameter_box = &board::terminal0.box;
    board::motors.write = [](const drivers::motor::sim::MotorSim::Control& control) {
        the_world->command_motors(control);
    };
    board::servos.write = [](const drivers::servo::sim::ServoSim::Control& control) {
        the_world->command_servos(control);
    };
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

[[nodiscard]] bool connect_can(board::RealWorld& world, const board::RunOptions& run) {
    if (!board::is_can_interface(run.can_interface)) return false;
    board::can1.interface = run.can_interface;
    board::can1.clock_speed = run.settings.speed;
    board::can1.watch = [](int descriptor) {
        if (!board::can1_received.watch(descriptor)) fail("cannot wait for the CAN socket");
    };
    board::can1.unwatch = [] { board::can1_received.unwatch(); };
    if (run.can_parts == nullptr) return true;
    if (!board::is_can_interface(run.can_parts)) return false;
    if (world.connect_can_parts(run.can_parts)) return true;
    std::fprintf(stderr, "error: cannot use '%s': %s\n", run.can_parts, std::strerror(errno));
    return false;
}

double seconds(std::uint64_t time_ns) {
    return static_cast<double>(time_ns) * 1e-9;
}

void print_refusals() {
    std::fprintf(host::facts, "\"not_allowed\": [");
    const char* separator = "";
    for (const Refusal& refusal : refusals()) {
        std::fprintf(host::facts,
                     "%s{\"what\": \"%s\", \"why\": \"%s\", \"cost\": \"%s\", \"remedy\": \"%s\"}",
                     separator, refusal.what, refusal.why, refusal.cost, refusal.remedy);
        separator = ", ";
    }
    std::fprintf(host::facts, "]");
}

void print_levels(double wall_s) {
    std::fprintf(host::facts, "\"levels\": [");
    for (unsigned i = 0; i < program.level_count; ++i) {
        const LevelFacts facts = facts_of_level(i);
        std::fprintf(host::facts,
                     "%s{\"level\": %u, \"cpu_s\": %0.6F, \"load\": %0.6F, \"wakes\": %llu, "
                     "\"worst_release_us\": %0.3F}",
                     i == 0 ? "" : ", ", program.levels[i].priority, seconds(facts.cpu_ns),
                     seconds(facts.cpu_ns) / wall_s, static_cast<unsigned long long>(facts.wakes),
                     static_cast<double>(facts.worst_release_ns) * 1e-3);
    }
    std::fprintf(host::facts, "]");
}

bool is_any_level_left() {
    for (unsigned i = 0; i < program.level_count; ++i) {
        if (unended_task(i) != nullptr) return true;
    }
    return false;
}

void tell_unrest() {
    if (!is_any_level_left()) {
        std::fputs("error: the graph did not stop within 1 s\n", stderr);
    }
    for (unsigned i = 0; i < program.level_count; ++i) {
        const Task* const task = unended_task(i);
        if (task == nullptr) continue;
        std::fprintf(stderr, "error: task '%s' of level %u does not end\n", task->name,
                     program.levels[i].priority);
    }
}

// Nothing that a task which does not end may be using is closed, or waited for.
[[noreturn]] void leave(std::FILE* log, std::FILE* truth) {
    std::fflush(host::facts);
    if (truth != nullptr) std::fflush(truth);
    if (log != nullptr && ftrylockfile(log) == 0) std::fflush(log);
    _exit(1);
}

// One line of JSON, with the keys of a simulated flight.
void print(const board::RealWorld& world, double wall_s) {
    std::uint64_t activations = 0;
    std::uint64_t lost_samples = 0;
    std::uint64_t missed_releases = 0;
    for (unsigned i = 0; i < program.task_count; ++i) {
        activations += program.tasks[i].counters->activations;
        lost_samples += program.tasks[i].counters->lost_samples;
    }
    for (unsigned i = 0; i < program.timer_count; ++i) {
        missed_releases += program.timers[i].state->missed;
    }
    std::fprintf(host::facts, "{\"activations\": %llu, \"lost_samples\": %llu",
                 static_cast<unsigned long long>(activations),
                 static_cast<unsigned long long>(lost_samples));
    std::fprintf(
        host::facts, ", \"missed_samples\": %llu, \"missed_releases\": %llu, \"real_time\": %s, ",
        static_cast<unsigned long long>(world.missed_samples()),
        static_cast<unsigned long long>(missed_releases), is_real_time() ? "true" : "false");
    // Threads do not interrupt each other where a program could count it.
    std::fprintf(host::facts, "\"unrecorded_activations\": %llu, ",
                 static_cast<unsigned long long>(recording_counts().lost));
    const char* const refused = refused_publications.newest.load();
    std::fprintf(host::facts, "\"refused_publications\": %u, \"refused_output\": \"%s\", ",
                 refused_publications.count.load(), refused == nullptr ? "" : refused);
    std::fprintf(
        host::facts, "\"missed_life_signs\": %llu, ",
        static_cast<unsigned long long>(missed_life_signs(program.watched, program.watched_count)));
    print_refusals();
    std::fprintf(host::facts, ", ");
    board::print_nonvolatile();
    print_levels(wall_s);
    std::fprintf(host::facts, ", ");
    world::print_flight_facts(host::facts, world.world(), wall_s, board::system0.restarts);
    std::fputs("}\n", host::facts);
}

int refuse_world() {
    std::fputs(
        "error: cannot start: a thread for the simulated world\n"
        "hint: allow more threads (ulimit -u) or more memory (ulimit -v)\n",
        stderr);
    if (finish()) return 2;
    tell_unrest();
    _exit(2);
}

}  // namespace

int main(int count, char** arguments) {
    host::begin(clock_us);
    std::signal(SIGPIPE, SIG_IGN);  // the reader of the facts may be gone; the log counts
    world::Options options{.vehicle = world::vehicle_of(board::kWorldVehicle)};
    board::RunOptions run;
    std::FILE* truth = nullptr;
    fly_on_without_log();
    if (!take_start_values(count, arguments)) return 2;
    if (!board::take_run_options(count, arguments, run)) return 2;
    if (!world::parse(count, arguments, options)) return 2;
    if (!open(options.log, board::log_storage.file) || !open(options.truth, truth)) return 2;
    board::log_storage.offer(options.log);
    if (run.nonvolatile != nullptr && !board::open_nonvolatile(run.nonvolatile)) return 2;
    if (options.mission != nullptr && !board::open_mission(options.mission)) return 2;
    if (!open_mavlink(options)) return 2;
    board::RealWorld world(options.conditions, options.vehicle, truth);
    connect(world);
    if (run.can_interface != nullptr && !connect_can(world, run)) return 2;
    if (run.link != nullptr && !offer_link(run.link)) return 2;
    if (!start(run.settings)) return 2;
    if (!world.begin()) return refuse_world();
    const Ending ending = wait_until(options.duration_us);
    const double wall_s = seconds(clock_ns()) / run.settings.speed;
    world.end();
    const bool came_to_rest = finish();
    if (!came_to_rest) tell_unrest();
    print(world, wall_s);
    if (is_any_level_left()) leave(board::log_storage.file, truth);
    const bool log_written = close(options.log, board::log_storage.file,
                                   board::log_storage.errors == 0, board::log_storage.reason);
    const bool truth_written = close(options.truth, truth, world.truth_is_whole());
    if (ending == Ending::kSignal) return 128 + ending_signal();
    if (!came_to_rest) return 1;
    if (board::system0.restarts) return kRestart;
    return log_written && truth_written ? 0 : 1;
}
