#include "structure/mechanics/oscillator_step.h"

#include <cmath>

namespace roseau::structure {
namespace {

/// Everything in units of the step: g = gamma dt, w = (w dt)^2. With s the answer to a unit impulse (s(0) = 0, s'(0) = 1):
struct Response {
  double impulse = 0;        // s(1)
  double impulse_slope = 0;  // s'(1)
  double relaxed = 0;        // s'(1) + g s(1): what is left of a unit displacement
  double step = 0;           // integral of s from 0 to 1: answer to a unit step
  double ramp = 0;           // integral of that: answer to a unit ramp
};

/// Integral of exp(-r t) from 0 to 1; and the integral of that integral.
double decay_integral(double r) { return r == 0 ? 1 : -std::expm1(-r) / r; }

double second_decay_integral(double r) {
  if (r > 0.5) return (1 - decay_integral(r)) / r;
  double term = 0.5;  // of the series sum (-r)^k / (k + 2)!
  double sum = 0;
  for (int k = 0; k < 30; ++k) {
    sum += term;
    term *= -r / (k + 3);
  }
  return sum;
}

/// By the power series of s: (k + 1) k s_{k+1} = -g k s_k - w s_{k-1}. For g and w up to 2 its terms stay small.
void add_integrals_by_series(double g, double w, Response& response) {
  double before = 0;
  double now = 1;
  for (int k = 1; k < 40; ++k) {  // now = s_k
    response.step += now / (k + 1);
    response.ramp += now / ((k + 1) * (k + 2));
    const double next = (-g * k * now - w * before) / ((k + 1) * k);
    before = now;
    now = next;
  }
}

Response overdamped(double g, double w, double root) {
  const double fast = g / 2 + root;
  const double slow = w / fast;  // g / 2 - root without its cancellation
  const double fast_decay = std::exp(-fast);
  const double slow_decay = std::exp(-slow);
  const double gap = 2 * root;
  return {.impulse = slow_decay * -std::expm1(-gap) / gap,
          .impulse_slope = (fast * fast_decay - slow * slow_decay) / gap,
          .relaxed = (fast * slow_decay - slow * fast_decay) / gap,
          .step = (decay_integral(slow) - decay_integral(fast)) / gap,
          .ramp = (second_decay_integral(slow) - second_decay_integral(fast)) / gap};
}

/// Also a little beyond critical damping, where the root is small: cos and sin of it turn into cosh and sinh.
Response oscillating(double g, double w) {
  const double square = w - g * g / 4;
  const double root = std::sqrt(std::abs(square));
  const double decay = std::exp(-g / 2);
  const double cosine = decay * (square >= 0 ? std::cos(root) : std::cosh(root));
  double sine = decay * (1 - square / 6 * (1 - square / 20));
  if (root > 1e-3) sine = decay * (square >= 0 ? std::sin(root) : std::sinh(root)) / root;
  Response response{.impulse = sine, .impulse_slope = cosine - g / 2 * sine, .relaxed = cosine + g / 2 * sine};
  if (g <= 2 && w <= 2) {
    add_integrals_by_series(g, w, response);
  } else {  // here w is not small: at least 3/4
    response.step = (1 - response.relaxed) / w;
    response.ramp = (1 - response.impulse - g * response.step) / w;
  }
  return response;
}

Response respond(double g, double w) {
  const double root_square = g * g / 4 - w;
  if (root_square > 0.25) return overdamped(g, w, std::sqrt(root_square));
  return oscillating(g, w);
}

}  // namespace

ExactOscillatorStep exact_oscillator_step(double stiffness_per_s2, double damping_per_s, double step_s) {
  const double w = stiffness_per_s2 * step_s * step_s;
  const Response r = respond(damping_per_s * step_s, w);
  const double square = step_s * step_s;
  return {.position = {.position = r.relaxed,
                       .velocity = r.impulse * step_s,
                       .begin_force = (r.step - r.ramp) * square,
                       .end_force = r.ramp * square},
          .velocity = {.position = -stiffness_per_s2 * step_s * r.impulse,
                       .velocity = r.impulse_slope,
                       .begin_force = (r.impulse - r.step) * step_s,
                       .end_force = r.step * step_s}};
}

}  // namespace roseau::structure
