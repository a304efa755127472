// Time of one call, beside the C library's: compare within one run.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>

#include "stator/random.hpp"
#include "stator/scalar.hpp"

namespace stator::math {
namespace {

constexpr std::size_t kCount = 1024;

template <typename T, typename Function>
void run(benchmark::State& state, double low, double high, Function function) {
    Random random(1);
    std::array<T, kCount> x{};
    for (T& value : x) value = static_cast<T>(low + (high - low) * random.uniform_double());
    std::size_t i = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(function(x[i]));
        i = (i + 1) % kCount;
    }
}

template <typename T>
void add(const std::string& name, double low, double high, T (*ours)(T), T (*theirs)(T)) {
    const std::string type = sizeof(T) == 4 ? "float " : "double ";
    benchmark::RegisterBenchmark((type + name + " stator").c_str(),
                                 [=](benchmark::State& state) { run<T>(state, low, high, ours); });
    benchmark::RegisterBenchmark((type + name + " libm").c_str(), [=](benchmark::State& state) {
        run<T>(state, low, high, theirs);
    });
}

template <typename T>
void add_all() {
    add<T>("sin, first octant", -0.78, 0.78, sin, std::sin);
    add<T>("sin, some turns", -30.0, 30.0, sin, std::sin);
    add<T>("cos, some turns", -30.0, 30.0, cos, std::cos);
    add<T>("tan, some turns", -30.0, 30.0, tan, std::tan);
    add<T>("atan", -10.0, 10.0, atan, std::atan);
    add<T>("asin", -1.0, 1.0, asin, std::asin);
    add<T>("exp", -10.0, 10.0, exp, std::exp);
    add<T>("log", 0.01, 100.0, log, std::log);
    add<T>("sqrt", 0.01, 100.0, sqrt, std::sqrt);
    add<T>("floor", -100.0, 100.0, floor<T>, std::floor);
    add<T>(
        "atan2 to 1", -3.0, 3.0, [](T x) { return atan2(x, T{1}); },
        [](T x) { return std::atan2(x, T{1}); });
    add<T>(
        "pow 5.255", 0.1, 2.0, [](T x) { return pow(x, T{5.25}); },
        [](T x) { return std::pow(x, T{5.25}); });
}

template <auto draw>
void noise(benchmark::State& state) {
    Random random(1);
    for (auto _ : state) benchmark::DoNotOptimize((random.*draw)());
}

BENCHMARK(noise<&Random::word>)->Name("random word");
BENCHMARK(noise<&Random::uniform_float>)->Name("uniform_float");
BENCHMARK(noise<&Random::gaussian_float>)->Name("gaussian_float");
BENCHMARK(noise<&Random::gaussian_double>)->Name("gaussian_double");

}  // namespace
}  // namespace stator::math

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    stator::math::add_all<float>();
    stator::math::add_all<double>();
    benchmark::RunSpecifiedBenchmarks();
}
