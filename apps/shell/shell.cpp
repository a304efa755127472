// Commands that a person types.
#include "shell.hpp"

#include <bit>
#include <cstring>

namespace stator::apps::shell {

namespace {

using Result = ParameterValue::Result;
using Type = ParameterValue::Type;

constexpr std::string_view kPrompt = "> ";
constexpr std::array<std::string_view, 8> kHelp{
    "help                  these lines",
    "top                   tasks, most urgent first, since the start",
    "listener              topics",
    "listener TOPIC        its newest sample",
    "param list [TEXT]     parameters, or those with TEXT in their names; * differs",
    "param get NAME        one parameter, by its id or as NODE.PARAMETER",
    "param set NAME VALUE  changes it, and keeps it",
    "Ctrl-C                ends a command",
};

template <std::size_t kSize>
std::string_view text_of(const std::array<uint8_t, kSize>& text) {
    std::size_t length = 0;
    while (length < kSize && text[length] != 0) ++length;
    return {reinterpret_cast<const char*>(text.data()), length};
}
template <std::size_t kSize>
std::string_view text_of(const std::array<char, kSize>& text) {
    std::size_t length = 0;
    while (length < kSize && text[length] != 0) ++length;
    return {text.data(), length};
}
// False: it is too long.
template <std::size_t kSize>
bool keep(std::array<char, kSize>& to, std::string_view text) {
    if (text.size() > kSize) return false;
    to = {};
    std::copy(text.begin(), text.end(), to.begin());
    return true;
}

std::string_view why(Result result) {
    switch (result) {
        case Result::kUnknown:
            return "unknown parameter; `param list` shows all";
        case Result::kOutOfRange:
        case Result::kNotANumber:
            return "out of range";
        case Result::kFixed:
            return "it cannot change while the graph runs";
        case Result::kArmed:
            return "it changes only while the vehicle is disarmed";
        case Result::kWrongType:
        default:
            return "refused";
    }
}

// A field of a sample, as the format says: `float[3] xyz;`
struct Field {
    std::string_view type;
    std::string_view name;
    uint32_t count = 1;
    bool is_array = false;
};

// The field that begins there in the format, and where the next one does.
Field field_of(std::string_view format, uint32_t& at) {
    std::string_view rest = format;
    rest.remove_prefix(std::min<std::size_t>(at, format.size()));
    const std::size_t end = std::min(rest.find(';'), rest.size());
    at += static_cast<uint32_t>(std::min(end + 1, rest.size()));
    rest = rest.substr(0, end);
    Field field{.type = next_word(rest), .name = rest};
    while (field.name.starts_with(' ')) field.name.remove_prefix(1);
    const std::size_t open = field.type.find('[');
    if (open == std::string_view::npos) return field;
    std::string_view digits = field.type;
    digits.remove_prefix(open + 1);
    if (!digits.empty()) digits.remove_suffix(1);
    field.count = static_cast<uint32_t>(read_whole(digits).value_or(0));
    field.is_array = true;
    field.type = field.type.substr(0, open);
    return field;
}

uint32_t bytes_of(std::string_view type) {
    if (type.ends_with("64_t") || type == "double") return 8;
    if (type.ends_with("32_t") || type == "float") return 4;
    if (type.ends_with("16_t")) return 2;
    return 1;
}

template <class Value>
Value read(const uint8_t* from) {
    Value value{};
    std::memcpy(&value, from, sizeof value);
    return value;
}

void put_value(Line& line, std::string_view type, const uint8_t* from) {
    const uint32_t bytes = bytes_of(type);
    if (type == "float") {
        line.put_real(static_cast<double>(read<float>(from)));
    } else if (type == "double") {
        line.put_real(read<double>(from));
    } else if (type == "bool") {
        line.put(*from != 0 ? "true" : "false");
    } else if (type.starts_with('u')) {
        uint64_t value = 0;
        std::memcpy(&value, from, bytes);
        line.put_whole(static_cast<int64_t>(value));
    } else if (bytes == 8) {
        line.put_whole(read<int64_t>(from));
    } else if (bytes == 4) {
        line.put_whole(read<int32_t>(from));
    } else if (bytes == 2) {
        line.put_whole(read<int16_t>(from));
    } else {
        line.put_whole(read<int8_t>(from));
    }
}

// Ticks as microseconds.
uint32_t us_of(uint32_t ticks, uint32_t hz) {
    return static_cast<uint32_t>(uint64_t{ticks} * 1'000'000 / hz);
}

}  // namespace

void Shell::step(ShellPorts& ports) {
    has_asked_ = false;
    while (ports.value.next()) take_value(*ports.value, ports);
    if (asking_ != kNobody && ports.now - asked_us_ > kPatience_us) {
        Desk& desk = desks_[asking_];
        asking_ = kNobody;
        if (desk.job != Job::kNone) {
            desk.console.out.put("no answer from the node with the parameters").end_line();
            end(desk);
        }
    }
    if (!ports.typed.next() || ports.typed->console >= kConsoles) return;
    const ShellText& typed = *ports.typed;
    Desk& desk = desks_[typed.console];
    if (typed.is_new) {
        desk.console.reset();
        end(desk);
    }
    const std::size_t length = std::min<std::size_t>(typed.length, typed.data.size());
    if (desk.console.type(std::span(typed.data).first(length))) {
        desk.console.out.put("^C").end_line();
        end(desk);
    }
    if (!typed.wants_text) return;
    if (desk.console.out.is_empty()) build_next(typed.console, ports);
    ports.printed.publish([&] {
        ShellText printed{.console = typed.console, .tag = typed.tag};
        printed.length = static_cast<uint8_t>(desk.console.out.take(printed.data));
        printed.has_more = desk.job != Job::kNone || !desk.console.out.is_empty() ||
                           desk.console.has_line() || desk.console.has_lost_line();
        return printed;
    });
}

// The next line of what the console's command prints; or the next command.
void Shell::build_next(unsigned index, ShellPorts& ports) {
    Desk& desk = desks_[index];
    switch (desk.job) {
        case Job::kHelp:
            return print_help(desk);
        case Job::kTop:
            return print_task(desk, ports);
        case Job::kTopics:
            return print_topic(desk, ports);
        case Job::kSample:
            return print_field(index, ports);
        case Job::kList:
        case Job::kGet:
        case Job::kSet:
            return ask_next(index, ports);
        case Job::kNone:
        default:
            break;
    }
    if (desk.console.has_lost_line()) {
        desk.console.forget_loss();
        desk.console.out.put("a line was lost: too long, or typed too fast").end_line();
        desk.console.out.put(kPrompt);
        return;
    }
    if (const auto line = desk.console.next_line()) begin(index, *line, ports);
}

void Shell::begin(unsigned index, std::string_view line, ShellPorts& ports) {
    Desk& desk = desks_[index];
    Line& out = desk.console.out;
    out.put(line.substr(0, 100)).end_line();  // what was typed, as terminals expect
    desk.at = 0;
    const std::string_view word = next_word(line);
    if (word.empty()) {
        end(desk);
    } else if (word == "help") {
        desk.job = Job::kHelp;
    } else if (word == "top") {
        desk.job = Job::kTop;
    } else if (word == "param") {
        begin_param(desk, line, ports);
    } else if (word == "listener") {
        const std::string_view name = next_word(line);
        desk.job = name.empty() ? Job::kTopics : Job::kSample;
        if (name.empty()) return;
        for (desk.topic = 0; desk.topic < ports.graph->topic_count; ++desk.topic) {
            if (name == ports.graph->topics[desk.topic].name) return;
        }
        out.put("unknown topic; `listener` shows all").end_line();
        end(desk);
    } else {
        out.put("unknown command; `help` shows all").end_line();
        end(desk);
    }
}

// Whatever it had is free for others.
void Shell::end(Desk& desk) {
    const auto index = static_cast<unsigned>(&desk - desks_.data());
    if (sample_of_ == index) sample_of_ = kNobody;
    if (asking_ == index) asking_ = kNobody;
    desk.job = Job::kNone;
    desk.console.out.put(kPrompt);
}

void Shell::print_help(Desk& desk) {
    desk.console.out.put(kHelp[desk.at]).end_line();
    if (++desk.at == kHelp.size()) end(desk);
}

// --- tasks ---

void Shell::print_task(Desk& desk, const ShellPorts& ports) {
    Line& out = desk.console.out;
    const uint32_t hz = observed_ticks_hz();
    const std::size_t end_of_response = hz != 0 ? 71 : 53;
    if (desk.at == 0) {
        out.put("lev task").fill(26).put("count").fill(37).put("/s").fill(44);
        if (hz != 0) out.put("last us").fill(53).put("max us").fill(62);
        out.put("resp us").fill(end_of_response).put("lost").end_line();
    }
    const ObservedTask& task = ports.graph->tasks[desk.at];
    const TaskCounters figures = figures_of(task);
    const uint64_t rate = ports.now == 0 ? 0 : figures.activations * 1'000'000ULL / ports.now;
    out.put_whole(task.level).put(task.level < 10 ? "   " : "  ").put(task.name);
    out.put(' ').fill(26).put_whole(figures.activations).put(' ').fill(37);
    out.put_whole(static_cast<int64_t>(rate)).put(' ').fill(44);
    if (hz != 0) {
        out.put_whole(us_of(figures.last_ticks, hz)).put(' ').fill(53);
        out.put_whole(us_of(figures.most_ticks, hz)).put(' ').fill(62);
    }
    out.put_whole(figures.latest_us).put(' ').fill(end_of_response);
    out.put_whole(figures.lost_samples).end_line();
    if (++desk.at == ports.graph->task_count) end(desk);
}

// --- topics ---

void Shell::print_topic(Desk& desk, const ShellPorts& ports) {
    if (desk.at < ports.graph->topic_count) {
        desk.console.out.put(ports.graph->topics[desk.at].name).end_line();
    }
    if (++desk.at >= ports.graph->topic_count) end(desk);
}

void Shell::take_sample(unsigned index, const ShellPorts& ports) {
    Desk& desk = desks_[index];
    Line& out = desk.console.out;
    const ObservedTopic& topic = ports.graph->topics[desk.topic];
    uint32_t number = 0;
    if (topic.bytes > kSampleBytes) {
        out.put("its samples are too long to be printed").end_line();
        return end(desk);
    }
    if (!copy_newest(*topic.topic, sample_.data(), topic.bytes, number)) {
        out.put("no sample yet").end_line();
        return end(desk);
    }
    sample_of_ = index;
    sample_at_ = 0;
    out.put("sample ").put_whole(number).end_line();
}

void Shell::print_field(unsigned index, const ShellPorts& ports) {
    constexpr std::size_t kLongestValue = 25;
    if (sample_of_ == kNobody) return take_sample(index, ports);
    if (sample_of_ != index) return;  // its turn comes
    Desk& desk = desks_[index];
    Line& out = desk.console.out;
    const ObservedTopic& topic = ports.graph->topics[desk.topic];
    const std::string_view format = topic.format;
    const Field field = field_of(format, desk.at);
    const uint32_t bytes = bytes_of(field.type);
    if (!field.name.starts_with('_')) {
        out.put("  ").put(field.name).put(':');
        for (uint32_t i = 0; i < field.count; ++i) {
            const uint32_t from = sample_at_ + i * bytes;
            if (from + bytes > topic.bytes) break;
            if (out.room() < kLongestValue) {
                out.put(" ...");
                break;
            }
            put_value(out.put(' '), field.type, sample_.data() + from);
        }
        out.end_line();
    }
    sample_at_ += bytes * field.count;
    if (desk.at >= format.size()) end(desk);
}

// --- parameters ---

void Shell::begin_param(Desk& desk, std::string_view line, const ShellPorts& ports) {
    Line& out = desk.console.out;
    const std::string_view action = next_word(line);
    const std::string_view name = next_word(line);
    const std::string_view value = next_word(line);
    desk.is_read = false;
    const bool is_list = action == "list";
    const bool is_get = action == "get" && !name.empty();
    const bool is_set = action == "set" && !value.empty();
    std::string_view error;
    if (!is_list && !is_get && !is_set) error = "expected list, get NAME, or set NAME VALUE";
    if (!keep(desk.name, name)) error = "the name is too long";
    if (!keep(desk.value, value)) error = "the value is too long";
    if (!ports.request.is_connected()) error = "the graph has no node that changes parameters";
    if (!error.empty()) {
        out.put(error).end_line();
        return end(desk);
    }
    desk.job = Job::kList;
    if (is_get) desk.job = Job::kGet;
    if (is_set) desk.job = Job::kSet;
}

void Shell::ask_next(unsigned index, ShellPorts& ports) {
    if (asking_ != kNobody || has_asked_) return;
    const Desk& desk = desks_[index];
    ParameterRequest request{};
    if (desk.job == Job::kList) {
        request.index = static_cast<uint16_t>(desk.at);
    } else {
        const std::string_view name = text_of(desk.name);
        std::copy(name.begin(), name.end(), request.name.begin());
    }
    ask(index, request, ports);
}

void Shell::ask(unsigned index, const ParameterRequest& request, ShellPorts& ports) {
    asking_ = index;
    has_asked_ = true;
    asked_us_ = ports.now;
    ++tag_;
    ports.request.publish([&] {
        ParameterRequest sent = request;
        sent.requester = ParameterRequest::Requester::kShell;
        sent.tag = tag_;
        return sent;
    });
}

void Shell::take_value(const ParameterValue& value, ShellPorts& ports) {
    const bool is_ours = value.requester == ParameterValue::Requester::kShell &&
                         value.tag == tag_ && asking_ != kNobody;
    if (!is_ours) return;
    const unsigned index = asking_;
    Desk& desk = desks_[index];
    asking_ = kNobody;
    switch (desk.job) {
        case Job::kList: {
            const std::string_view part = text_of(desk.name);
            const bool is_there = value.result == Result::kRead;
            const bool is_named = text_of(value.id).find(part) != std::string_view::npos ||
                                  text_of(value.name).find(part) != std::string_view::npos;
            if (is_there && is_named) print_value(desk, value);
            if (++desk.at >= value.count) end(desk);
            return;
        }
        case Job::kGet:
            value.result == Result::kRead ? print_value(desk, value) : refuse(desk, value);
            return end(desk);
        case Job::kSet:
            return set(index, value, ports);
        default:  // it was ended meanwhile
            return;
    }
}

// The answer to a reading tells the type; that to a change, what became of it.
void Shell::set(unsigned index, const ParameterValue& value, ShellPorts& ports) {
    Desk& desk = desks_[index];
    const std::string_view text = text_of(desk.value);
    if (value.result == Result::kWritten) {
        print_value(desk, value);
        return end(desk);
    }
    if (desk.is_read || value.result != Result::kRead) {
        refuse(desk, value);
        return end(desk);
    }
    desk.is_read = true;
    ParameterRequest request{.action = ParameterRequest::Action::kSet,
                             .type = static_cast<ParameterRequest::Type>(value.type),
                             .name = value.name};
    bool is_number = true;
    if (value.type == Type::kFloat) {
        const auto real = read_real(text);
        is_number = real.has_value();
        request.float_value = real.value_or(0.0F);
    } else {
        auto whole = read_whole(text);
        if (value.type == Type::kBool && text == "true") whole = 1;
        if (value.type == Type::kBool && text == "false") whole = 0;
        is_number = whole.has_value();
        request.int_value = whole.value_or(0);
    }
    if (is_number) return ask(index, request, ports);
    desk.console.out.put(value.type == Type::kFloat ? "expected a number"
                                                    : "expected a whole number");
    desk.console.out.put(", found '").put(text).put('\'').end_line();
    end(desk);
}

void Shell::print_value(Desk& desk, const ParameterValue& value) {
    Line& out = desk.console.out;
    const auto put = [&](float real, int32_t whole) {
        if (value.type == Type::kFloat) {
            out.put_real(static_cast<double>(real));
        } else if (value.type == Type::kBool) {
            out.put(whole != 0 ? "true" : "false");
        } else {
            out.put_whole(whole);
        }
    };
    const bool is_changed = value.type == Type::kFloat
                                ? std::bit_cast<uint32_t>(value.float_value) !=
                                      std::bit_cast<uint32_t>(value.float_default)
                                : value.int_value != value.int_default;
    out.put(is_changed ? "* " : "  ").put(text_of(value.id)).fill(20);
    put(value.float_value, value.int_value);
    if (is_changed) {
        out.put(" (graph: ");
        put(value.float_default, value.int_default);
        out.put(')');
    }
    out.put(' ').fill(32).put(text_of(value.name)).end_line();
}

void Shell::refuse(Desk& desk, const ParameterValue& value) {
    Line& out = desk.console.out;
    out.put(why(value.result));
    if (value.result == Result::kOutOfRange) {
        out.put(": ");
        if (value.type == Type::kFloat) {
            out.put_real(static_cast<double>(value.float_least)).put(" to ");
            out.put_real(static_cast<double>(value.float_most));
        } else {
            out.put_whole(value.int_least).put(" to ").put_whole(value.int_most);
        }
    }
    out.end_line();
}

}  // namespace stator::apps::shell
