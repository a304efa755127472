// What a host program says about a thread that died: which node ran on it, and the input that this
// node read although it was absent. Bare metal has a record of its own (runtime/cortex_m).
#pragma once

#include <cstdint>

#ifdef __linux__
#include <cstdio>
#include <cstdlib>
#include <cstring>
#endif

namespace stator {

#ifdef __linux__

inline constexpr bool kChecksInputs = true;
inline thread_local const char* running_node = nullptr;  // none between activations
inline thread_local const char* absent_input = nullptr;

// Prints the input and aborts.
[[noreturn, gnu::cold, gnu::noinline]] inline void fail_absent(const char* input) {
    absent_input = input;
    if (std::strcmp(input, "params") == 0) {  // every graph has them
        std::fputs(
            "stator: read the absent input 'params'; a test gives them: "
            "ports.params = Input(params)\n",
            stderr);
    } else {
        std::fprintf(stderr,
                     "stator: read the absent input '%s'; test it first: if (ports.%s) ...\n",
                     input, input);
    }
    std::abort();
}

// The name of a port, for `fail_absent`.
class PortName {
  public:
    PortName() = default;
    explicit PortName(const char* name) : name_(name) {}
    const char* get() const { return name_; }

  private:
    const char* name_ = "of a test";
};

#else

inline constexpr bool kChecksInputs = false;
[[noreturn]] void fail_absent(const char* input);  // nobody calls it
class PortName {
  public:
    PortName() = default;
    [[gnu::always_inline]] explicit PortName(const char* /*name*/) {}
    static const char* get() { return ""; }
};

#endif

}  // namespace stator
