// Replays the recording in a log with the graph that was built for this program, and prints what
// came of it as JSON. Exit status: 0 it ran, whatever differs; 2 there is nothing to replay.
#include <cstdio>
#include <cstdlib>

#include "run.hpp"
#include "stator/host.hpp"
#include "stator/start_options.hpp"

namespace {

using namespace stator::replay;
namespace host = stator::host;

constexpr unsigned kEndlessStep_s = 10;
uint64_t (*const kNow_us)() = [] { return newest_activation_us; };

void print_hex(const char* key, const std::vector<uint8_t>& bytes) {
    std::fprintf(host::facts, ", \"%s\": \"", key);
    for (const uint8_t byte : bytes) std::fprintf(host::facts, "%02x", byte);
    std::fprintf(host::facts, "\"");
}

void print(const Recording& recording, const Difference& difference) {
    const char* const kinds[] = {"value", "missing", "extra"};
    std::fprintf(host::facts, ", \"first\": {\"kind\": \"%s\", \"topic\": \"%s\", \"number\": %u, ",
                 kinds[static_cast<int>(difference.kind)],
                 recording.topics[difference.topic].name.c_str(), difference.number);
    std::fprintf(host::facts, "\"now_us\": %llu, \"recorded_hash\": %u, \"hash\": %u",
                 static_cast<unsigned long long>(difference.now_us), difference.recorded_hash,
                 difference.hash);
    print_hex("recorded", difference.recorded);
    print_hex("replayed", difference.replayed);
    std::fprintf(host::facts, "}");
}

}  // namespace

int main(int count, char** arguments) {
    if (!stator::take_start_values(count, arguments)) return 2;
    if (count != 3) {
        std::fputs(
            "error: expected a log, the number of its bytes to use, and --param for each value "
            "that "
            "replaced the graph's\n",
            stderr);
        return 2;
    }
    const auto recording = read_recording(arguments[1], std::strtoull(arguments[2], nullptr, 10));
    if (!recording.has_value()) {
        std::fprintf(stderr, "error: cannot read the recording in '%s'\n", arguments[1]);
        return 2;
    }
    host::begin(kNow_us);
    host::watch_steps(kEndlessStep_s);
    Replay replay(*recording);
    if (!replay.scan()) {
        std::fprintf(stderr, "error: the recording in '%s' is inconsistent\n", arguments[1]);
        return 2;
    }
    replay.run();
    std::fprintf(host::facts,
                 "{\"activations\": %llu, \"until_us\": %llu, \"recorded_until_us\": %llu",
                 static_cast<unsigned long long>(replay.activations()),
                 static_cast<unsigned long long>(replay.until_us()),
                 static_cast<unsigned long long>(replay.recorded_until_us()));
    std::fprintf(host::facts, ", \"topics\": {");
    const char* comma = "";
    for (size_t i = 0; i < recording->topics.size(); ++i) {
        const TopicResult& result = replay.results()[i];
        if (result.compared + result.different == 0) continue;
        std::fprintf(host::facts, "%s\"%s\": {\"compared\": %llu, \"different\": %llu}", comma,
                     recording->topics[i].name.c_str(),
                     static_cast<unsigned long long>(result.compared),
                     static_cast<unsigned long long>(result.different));
        comma = ", ";
    }
    std::fprintf(host::facts, "}");
    if (replay.first().has_value()) print(*recording, *replay.first());
    std::fputs("}\n", host::facts);
    return 0;
}
