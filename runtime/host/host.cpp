// What nodes print, and how programs of this machine die: crashes and endless steps.
#include "stator/host.hpp"

#include <execinfo.h>
#include <sys/time.h>
#include <ucontext.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>

#include "stator/running.hpp"

// Of the linker: where the program lies.
extern "C" const char kProgramBegin __asm__("__executable_start");

// A sanitizer reports first, and then aborts.
#ifdef __SANITIZE_ADDRESS__
extern "C" const char* __asan_default_options() {
    return "abort_on_error=1:detect_leaks=0:handle_abort=0:print_legend=0";
}
extern "C" const char* __ubsan_default_options() {
    return "abort_on_error=1:print_stacktrace=0";
}
constexpr bool kIsSanitized = true;
#else
constexpr bool kIsSanitized = false;
#endif

namespace stator::host {

namespace {

constexpr std::size_t kStackBytes = 65'536;
constexpr int kMaxFrames = 48;
constexpr std::size_t kMaxLine = 2048;
constexpr double kMicro = 1e-6;

uint64_t (*clock_us)() = nullptr;

// --- what nodes print ---

// `cookie`: whether the next character begins a line.
bool out_begins = true;
bool err_begins = true;

void write_all(const char* bytes, std::size_t count) {
    while (count != 0) {
        const ssize_t written = write(STDERR_FILENO, bytes, count);
        if (written < 0 && errno != EINTR) return;
        if (written <= 0) continue;
        bytes += written;
        count -= static_cast<std::size_t>(written);
    }
}

// Called by the thread that prints, so that it knows the node.
ssize_t write_lines(void* cookie, const char* text, std::size_t size) {
    bool& begins = *static_cast<bool*>(cookie);
    std::array<char, kMaxLine> line{};
    for (std::size_t at = 0; at < size;) {
        const void* const end = std::memchr(text + at, '\n', size - at);
        const std::size_t rest =
            end == nullptr
                ? size - at
                : static_cast<std::size_t>(static_cast<const char*>(end) - text) + 1 - at;
        std::size_t head = 0;
        if (begins && running_node != nullptr) {
            head = static_cast<std::size_t>(std::snprintf(
                line.data(), line.size(),
                "[%11.6f s] %s: ", static_cast<double>(clock_us()) * kMicro, running_node));
        }
        const std::size_t part = rest < line.size() - head ? rest : line.size() - head;
        std::memcpy(line.data() + head, text + at, part);
        write_all(line.data(), head + part);
        at += part;
        begins = text[at - 1] == '\n';
    }
    return static_cast<ssize_t>(size);
}

std::FILE* stream(bool& begins, int mode) {
    std::FILE* const file = fopencookie(
        &begins, "w", {.read = nullptr, .write = write_lines, .seek = nullptr, .close = nullptr});
    if (file != nullptr) std::setvbuf(file, nullptr, mode, mode == _IONBF ? 0 : BUFSIZ);
    return file;
}

void take_over_output() {
    const int descriptor = dup(STDOUT_FILENO);
    std::FILE* const own = descriptor < 0 ? nullptr : fdopen(descriptor, "w");
    std::FILE* const out = stream(out_begins, _IOLBF);
    std::FILE* const err = stream(err_begins, _IONBF);
    if (own == nullptr || out == nullptr || err == nullptr) return;
    dup2(STDERR_FILENO, STDOUT_FILENO);
    facts = own;
    stdout = out;
    stderr = err;
}

// --- how they die ---

// A line of the report, made without any function that a signal handler may not call.
class Line {
  public:
    void text(const char* words) {
        while (*words != '\0' && size_ < bytes_.size() - 1) bytes_[size_++] = *words++;
    }
    void number(uint64_t value, unsigned base) {
        std::array<char, 24> digits{};
        unsigned count = 0;
        do {
            digits[count++] = "0123456789abcdef"[value % base];
            value /= base;
        } while (value != 0);
        while (count != 0 && size_ < bytes_.size() - 1) bytes_[size_++] = digits[--count];
    }
    void send() {
        bytes_[size_++] = '\n';
        write_all(bytes_.data(), size_);
    }

  private:
    std::array<char, kMaxLine> bytes_{};
    std::size_t size_ = 0;
};

// Where the program was when the signal came; 0 if this processor is not known here.
uint64_t interrupted_at(const void* context) {
    [[maybe_unused]] const auto* const state = static_cast<const ucontext_t*>(context);
#if defined(__x86_64__)
    return static_cast<uint64_t>(state->uc_mcontext.gregs[REG_RIP]);
#elif defined(__aarch64__)
    return state->uc_mcontext.pc;
#else
    return 0;
#endif
}

void report(const char* what, const void* context) {
    Line line;
    line.text("\nstator: crash ");
    line.text(what);
    line.text(" node=");
    line.text(running_node == nullptr ? "-" : running_node);
    line.text(" input=");
    line.text(absent_input == nullptr ? "-" : absent_input);
    line.text(" at_us=");
    line.number(clock_us(), 10);
    line.text(" base=");
    line.number(reinterpret_cast<uintptr_t>(&kProgramBegin), 16);
    line.text(" pc=");
    line.number(interrupted_at(context), 16);
    line.text(" frames=");
    std::array<void*, kMaxFrames> frames{};
    const int count = backtrace(frames.data(), kMaxFrames);
    for (int i = 0; i < count; ++i) {
        if (i != 0) line.text(",");
        line.number(reinterpret_cast<uintptr_t>(frames[static_cast<unsigned>(i)]), 16);
    }
    line.send();
}

const char* name_of(int number) {
    switch (number) {
        case SIGSEGV:
            return "SIGSEGV";
        case SIGFPE:
            return "SIGFPE";
        case SIGBUS:
            return "SIGBUS";
        case SIGILL:
            return "SIGILL";
        default:
            return "SIGABRT";
    }
}

void end_by(int number) {
    std::signal(number, SIG_DFL);
    raise(number);
}

void die(int number, siginfo_t*, void* context) {
    report(name_of(number), context);
    end_by(number);
}

// --- steps that do not end ---

unsigned limit_ticks = 0;
unsigned ticks = 0;
uint32_t activations_before = 0;

void tick(int, siginfo_t*, void* context) {
    const bool is_same = running_node != nullptr && activations == activations_before;
    activations_before = activations;
    ticks = is_same ? ticks + 1 : 0;
    if (ticks < limit_ticks) return;
    report("ENDLESS", context);
    end_by(SIGABRT);
}

void handle(int number, void (*handler)(int, siginfo_t*, void*), int flags) {
    struct sigaction action {};
    action.sa_sigaction = handler;
    action.sa_flags = flags | SA_SIGINFO | SA_ONSTACK;
    sigaction(number, &action, nullptr);
}

}  // namespace

void begin(uint64_t (*now_us)()) {
    clock_us = now_us;
    take_over_output();
    std::array<void*, 1> first{};
    backtrace(first.data(), 1);  // loads what it needs, which a handler may not
    begin_thread();
    handle(SIGABRT, die, SA_NODEFER);
    if (kIsSanitized) return;
    for (const int number : {SIGSEGV, SIGFPE, SIGBUS, SIGILL}) {
        handle(number, die, SA_NODEFER);
    }
}

void begin_thread() {
    thread_local const auto stack = std::make_unique<char[]>(kStackBytes);
    const stack_t own{.ss_sp = stack.get(), .ss_flags = 0, .ss_size = kStackBytes};
    sigaltstack(&own, nullptr);
}

void watch_steps(unsigned limit_s) {
    limit_ticks = limit_s;
    handle(SIGVTALRM, tick, SA_RESTART);
    const itimerval second{.it_interval = {.tv_sec = 1, .tv_usec = 0},
                           .it_value = {.tv_sec = 1, .tv_usec = 0}};
    setitimer(ITIMER_VIRTUAL, &second, nullptr);
}

}  // namespace stator::host
