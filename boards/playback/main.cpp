// Runs the graph that was built for this board once over a recording, and writes its log.
//
// Exit status: 0 the whole recording was played; 1 the log could not be written whole; 2 a wrong
// argument, or a file that cannot be opened.
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "devices.hpp"
#include "playing.hpp"
#include "stator/host.hpp"
#include "stator/virtual.hpp"

namespace {

using namespace stator;

// After the last sample, so that slow nodes and the logger see it.
constexpr unsigned kEndlessStep_s = 10;  // of processor time
constexpr std::uint64_t kAfterrun_us = 2'000'000;

struct Options {
    const char* recording = nullptr;
    const char* log = nullptr;  // none: no log
};

[[nodiscard]] bool parse(int count, const char* const* arguments, Options& options) {
    for (int i = 1; i + 1 < count; i += 2) {
        const std::string_view option = arguments[i];
        if (option == "--recording") options.recording = arguments[i + 1];
        if (option == "--log") options.log = arguments[i + 1];
        if (option != "--recording" && option != "--log") return false;
    }
    return count % 2 == 1 && options.recording != nullptr;
}

[[nodiscard]] bool open_log(const char* path) {
    if (path == nullptr) return true;
    board::log_storage.file = std::fopen(path, "wb");
    if (board::log_storage.file != nullptr) return true;
    std::fprintf(stderr, "error: cannot open '%s': %s\n", path, std::strerror(errno));
    return false;
}

[[nodiscard]] bool close_log(const char* path) {
    if (board::log_storage.file == nullptr) return true;
    const bool closed = std::fclose(board::log_storage.file) == 0;
    if (closed && board::log_storage.errors == 0) return true;
    std::fprintf(stderr, "error: cannot write all data to '%s'\n", path);
    return false;
}

}  // namespace

int main(int count, char** arguments) {
    host::begin([] { return executor.now_us; });
    host::watch_steps(kEndlessStep_s);
    Options options;
    if (!parse(count, arguments, options)) {
        std::fputs("error: expected the options --recording FILE and --log FILE\n", stderr);
        return 2;
    }
    board::Recording recording;
    if (!recording.load(options.recording) || !open_log(options.log)) return 2;
    board::play(recording);
    start();
    run_until(recording.end_us() + kAfterrun_us);
    return close_log(options.log) ? 0 : 1;
}
