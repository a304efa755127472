// Commands that a person types: help, top, listener, param.
#pragma once

#include <array>

#include "console.hpp"
#include "shell_ports.hpp"
#include "text.hpp"

namespace stator::apps::shell {

// Text is printed only when it is asked for: each request gets one piece, and no line is built
// before the one in front of it is taken. So an activation builds one line at most, whatever is
// typed. One console at a time has the buffer of a sample, and one has the request for a parameter
// that has no answer yet; others wait.
class Shell {
  public:
    void step(ShellPorts& ports);

  private:
    static constexpr unsigned kConsoles = 2;
    static constexpr std::size_t kSampleBytes = 384;
    static constexpr uint64_t kPatience_us = 1'000'000;
    static constexpr unsigned kNobody = kConsoles;

    enum class Job : uint8_t { kNone, kHelp, kTop, kTopics, kSample, kList, kGet, kSet };
    struct Desk {
        Console console;
        Job job = Job::kNone;
        uint32_t at =
            0;  // the next row: a line, a task, a topic, a byte of the format, a parameter
        uint32_t topic = 0;
        std::array<char, 92> name{};  // of a parameter, or what a list's names contain
        std::array<char, 24> value{};
        bool is_read = false;  // the parameter to set: then its type is known
    };

    void build_next(unsigned index, ShellPorts& ports);
    void begin(unsigned index, std::string_view line, ShellPorts& ports);
    void end(Desk& desk);
    void print_help(Desk& desk);
    void print_task(Desk& desk, const ShellPorts& ports);
    void print_topic(Desk& desk, const ShellPorts& ports);
    void take_sample(unsigned index, const ShellPorts& ports);
    void print_field(unsigned index, const ShellPorts& ports);
    void begin_param(Desk& desk, std::string_view line, const ShellPorts& ports);
    void ask(unsigned index, const ParameterRequest& request, ShellPorts& ports);
    void ask_next(unsigned index, ShellPorts& ports);
    void take_value(const ParameterValue& value, ShellPorts& ports);
    void set(unsigned index, const ParameterValue& value, ShellPorts& ports);
    void print_value(Desk& desk, const ParameterValue& value);
    void refuse(Desk& desk, const ParameterValue& value);

    std::array<Desk, kConsoles> desks_{};
    std::array<uint8_t, kSampleBytes> sample_{};
    uint32_t sample_at_ = 0;        // the next byte of it to print
    unsigned sample_of_ = kNobody;  // who prints it
    unsigned asking_ = kNobody;     // whose request has no answer yet
    bool has_asked_ = false;        // in this activation, whose answer may be there at once
    uint64_t asked_us_ = 0;
    uint8_t tag_ = 0;
};

}  // namespace stator::apps::shell
