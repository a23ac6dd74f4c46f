/* A straight-line program on jets: balls of value, gradient and Hessian in a box, in blocks of lanes.
 *
 * Formulas and roundings are those of intervals.py and jets.py; it must be compiled without contraction to fused
 * operations. A jet of k parameters has 2 + 2 k + k (k + 1) / 2 rows: value and gradient at the centre and anywhere,
 * packed Hessian. Each operation is seven numbers: code, result, three arguments, and two places in the tables.
 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#define BLOCK 32
#define LANES for (int l = 0; l < BLOCK; l++)
#define WIDTH 7
#define TEMPORARIES 6
#define MOST_PARAMETERS 64
#define MOST_TERMS 64

typedef intptr_t integer;   /* as wide as a pointer: structures are arrays of such numbers */
typedef double lane[BLOCK];
typedef struct { double u, slack, growth, tiny, libm, pi; } rounding;
typedef struct { double mid, rad; } ball;
typedef struct { integer k; lane *mid, *rad; const integer *support; } jet;   /* `support` are its parameters among all */

typedef struct {
    integer operations, inputs, outputs, registers, conditions, rows, parameters;
    const integer *code, *tables, *results;
    const double *numbers;
} program;

enum { CONSTANT, PI, ADD, NEGATE, MULTIPLY, POWER, INVERSE, SQRT, SIN, COS, ARCTAN, EXP, LOG, POLYNOMIAL, SELECT,
       ARCTAN2, FLOOR, BELOW, OR, AND, NOT, INPUT };

static __thread rounding R;
static __thread int cutting;
static integer none[MOST_PARAMETERS];   /* places of no parameter */

static inline double magnitude(double mid, double rad) { return (fabs(mid) + rad) * R.growth; }
static inline double round_down(double x) { return x - (2 * R.u * fabs(x) + R.tiny); }
static inline double low(ball x) { return round_down(x.mid - x.rad); }
static inline double high(ball x) { return -round_down(-x.mid - x.rad); }
static inline double error(double am, double ar, double bm, double br) {
    double size = fabs(bm);
    return (fabs(am) + ar) * (br + R.slack * size) + ar * size;
}
static inline ball exact(double x) { return (ball){x, 0}; }
static inline ball negative(ball x) { return (ball){-x.mid, x.rad}; }
static inline ball product(ball a, ball b) {
    return (ball){a.mid * b.mid, error(a.mid, a.rad, b.mid, b.rad) * R.growth + R.tiny};
}
static inline ball sum(ball a, ball b) {
    double mid = a.mid + b.mid;
    return (ball){mid, (a.rad + b.rad + R.u * fabs(mid)) * R.growth + R.tiny};
}
static ball between(double low, double high) {
    double mid = low + (high - low) / 2;
    return (ball){mid, fmax(high - mid, mid - low) * R.growth + R.tiny};
}
static ball inverse(ball x) {
    double margin = fabs(x.mid) * (1 - 4 * R.u) - x.rad;
    if (!(margin > 0)) return (ball){NAN, NAN};
    double mid = 1 / x.mid;
    return (ball){mid, (x.rad / margin + R.slack) * fabs(mid) * R.growth + R.tiny};
}
static ball power(ball x, integer n) {
    double mid = 1, steep = 1, size = magnitude(x.mid, x.rad);
    for (integer k = 0; k < n; k++) {
        mid *= x.mid;
        if (k) steep *= size;
    }
    return (ball){mid, (n * steep * x.rad + (n + 1) * R.u * fabs(mid)) * R.growth + R.tiny};
}
static ball root(ball x) {
    double margin = x.mid * (1 - 4 * R.u) - x.rad;
    if (!(margin > 0)) return (ball){NAN, NAN};
    double mid = sqrt(x.mid);
    return (ball){mid, (x.rad / (mid + sqrt(margin)) + R.slack * mid) * R.growth + R.tiny};
}
static ball wave(double mid, double slope, double rad) {
    double wide = (fabs(slope) + R.libm) * rad + rad * rad / 2 + R.libm, most = 1 + fabs(mid);
    return (ball){mid, (wide > most ? most : wide) * R.growth + R.tiny};
}
static ball sine(ball x) { return wave(sin(x.mid), cos(x.mid), x.rad); }
static ball cosine(ball x) { return wave(cos(x.mid), sin(x.mid), x.rad); }
static ball arc(ball x) {
    return between(round_down(atan(low(x)) - R.libm), -round_down(-(atan(high(x)) + R.libm)));
}
static ball exponential(ball x) {
    double mid = exp(x.mid);
    double rad = mid * (x.rad * exp(x.rad) * (1 + R.libm) + R.libm) * (1 + 2 * R.libm);
    return (ball){mid, rad * R.growth + R.tiny};
}
static ball logarithm(ball x) {
    double margin = x.mid * (1 - 4 * R.u) - x.rad;
    if (!(margin > 0)) return (ball){NAN, NAN};
    double mid = log(x.mid);
    return (ball){mid, (x.rad / margin + R.libm * fabs(mid)) * (1 + R.libm) * R.growth + R.tiny};
}
static ball nonnegative(ball x) { return between(fmax(low(x), 0), fmax(high(x), 0)); }

static inline integer gradient(integer k, int part, integer i) { return 2 + part * k + i; }
static inline integer hessian(integer k, integer i, integer j) { return 2 + 2 * k + (i > j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i); }
static inline integer rows(integer k) { return 2 + 2 * k + k * (k + 1) / 2; }
static inline ball at(jet x, integer row, int l) { return (ball){x.mid[row][l], x.rad[row][l]}; }
static inline void put(jet x, integer row, int l, ball b) { x.mid[row][l] = b.mid; x.rad[row][l] = b.rad; }

/* Intersect value and gradient anywhere with what the Taylor form about the centre gives. */
static void cut(jet x, const lane *half) {
    if (!cutting) return;
    integer k = x.k;
    lane change = {0};
    for (integer i = 0; i < k; i++) {
        lane moved = {0};
        for (integer j = 0; j < k; j++) {
            integer row = hessian(k, i, j);
            const double *width = half[x.support[j]];
            LANES moved[l] += magnitude(x.mid[row][l], x.rad[row][l]) * width[l];
        }
        integer c = gradient(k, 0, i), a = gradient(k, 1, i);
        const double *width = half[x.support[i]];
        LANES {
            double rad = (x.rad[c][l] + moved[l]) * R.growth + R.tiny;
            change[l] += width[l] * (magnitude(x.mid[c][l], x.rad[c][l]) + moved[l] / 2);
            int keep = x.rad[a][l] <= rad;
            x.mid[a][l] = keep ? x.mid[a][l] : x.mid[c][l];
            x.rad[a][l] = keep ? x.rad[a][l] : rad;
        }
    }
    LANES {
        double rad = (x.rad[0][l] + change[l]) * R.growth + R.tiny;
        int keep = x.rad[1][l] <= rad;
        x.mid[1][l] = keep ? x.mid[1][l] : x.mid[0][l];
        x.rad[1][l] = keep ? x.rad[1][l] : rad;
    }
}

static void copy_row(jet to, integer row, jet from, integer place, double sign) {
    if (place < 0) LANES { to.mid[row][l] = 0; to.rad[row][l] = 0; }
    else LANES { to.mid[row][l] = sign * from.mid[place][l]; to.rad[row][l] = from.rad[place][l]; }
}

/* Rows of a jet of fewer parameters for each row of a result; `own` are its places of the result's parameters, or -1. */
static integer place_gradient(jet x, const integer *own, int part, integer i) { return own[i] < 0 ? -1 : gradient(x.k, part, own[i]); }
static integer place_hessian(jet x, const integer *own, integer i, integer j) {
    return own[i] < 0 || own[j] < 0 ? -1 : hessian(x.k, own[i], own[j]);
}

static void add_row(jet y, integer row, jet a, integer p, jet b, integer q) {
    if (p < 0) copy_row(y, row, b, q, 1);
    else if (q < 0) copy_row(y, row, a, p, 1);
    else LANES {
        double mid = a.mid[p][l] + b.mid[q][l];
        y.rad[row][l] = (a.rad[p][l] + b.rad[q][l] + R.u * fabs(mid)) * R.growth + R.tiny;
        y.mid[row][l] = mid;
    }
}

static void add(jet y, jet a, jet b, const integer *ia, const integer *ib, const lane *half) {
    for (int part = 0; part < 2; part++) {
        add_row(y, part, a, part, b, part);
        for (integer i = 0; i < y.k; i++)
            add_row(y, gradient(y.k, part, i), a, place_gradient(a, ia, part, i), b, place_gradient(b, ib, part, i));
    }
    for (integer i = 0; i < y.k; i++)
        for (integer j = 0; j <= i; j++)
            add_row(y, hessian(y.k, i, j), a, place_hessian(a, ia, i, j), b, place_hessian(b, ib, i, j));
    if (a.k && b.k) cut(y, half);
}

/* Add the product of two rows to a sum of products, whose radius is completed by `close_row`. */
static inline void add_product(double *mid, double *rad, const jet a, integer p, const jet b, integer q) {
    if (p < 0 || q < 0) return;
    LANES {
        mid[l] += a.mid[p][l] * b.mid[q][l];
        rad[l] += error(a.mid[p][l], a.rad[p][l], b.mid[q][l], b.rad[q][l]);
    }
}
static inline void close_row(jet y, integer row, const double *mid, const double *rad) {
    LANES { y.mid[row][l] = mid[l]; y.rad[row][l] = rad[l] * R.growth + R.tiny; }
}

static void multiply(jet y, jet a, jet b, const integer *ia, const integer *ib, const lane *half) {
    for (int part = 0; part < 2; part++) {
        lane mid = {0}, rad = {0};
        add_product(mid, rad, a, part, b, part);
        close_row(y, part, mid, rad);
        for (integer i = 0; i < y.k; i++) {
            lane slope = {0}, room = {0};
            add_product(slope, room, a, part, b, place_gradient(b, ib, part, i));
            add_product(slope, room, b, part, a, place_gradient(a, ia, part, i));
            close_row(y, gradient(y.k, part, i), slope, room);
        }
    }
    for (integer i = 0; i < y.k; i++)
        for (integer j = 0; j <= i; j++) {
            lane mid = {0}, rad = {0};
            add_product(mid, rad, a, 1, b, place_hessian(b, ib, i, j));
            add_product(mid, rad, b, 1, a, place_hessian(a, ia, i, j));
            add_product(mid, rad, a, place_gradient(a, ia, 1, i), b, place_gradient(b, ib, 1, j));
            add_product(mid, rad, a, place_gradient(a, ia, 1, j), b, place_gradient(b, ib, 1, i));
            close_row(y, hessian(y.k, i, j), mid, rad);
        }
    if (a.k && b.k) cut(y, half);
}

static void negate(jet y, jet x) {
    for (integer row = 0; row < rows(y.k); row++) copy_row(y, row, x, row, -1);
}

/* A function of x from its value, first and second derivative: rows 0 and 1, 2 and 3, 4 of `of`. */
static void chain(jet y, jet x, jet of, const lane *half) {
    for (int part = 0; part < 2; part++) {
        copy_row(y, part, of, part, 1);
        for (integer i = 0; i < y.k; i++) {
            lane mid = {0}, rad = {0};
            add_product(mid, rad, of, 2 + part, x, gradient(x.k, part, i));
            close_row(y, gradient(y.k, part, i), mid, rad);
        }
    }
    for (integer i = 0; i < y.k; i++) {
        lane steep, room;
        LANES {
            ball slope = product(at(of, 4, l), at(x, gradient(x.k, 1, i), l));
            steep[l] = slope.mid, room[l] = slope.rad;
        }
        for (integer j = 0; j <= i; j++) {
            integer row = hessian(x.k, i, j), other = gradient(x.k, 1, j);
            LANES {
                double mid = of.mid[3][l] * x.mid[row][l] + steep[l] * x.mid[other][l];
                double rad = error(of.mid[3][l], of.rad[3][l], x.mid[row][l], x.rad[row][l])
                    + error(steep[l], room[l], x.mid[other][l], x.rad[other][l]);
                y.mid[hessian(y.k, i, j)][l] = mid;
                y.rad[hessian(y.k, i, j)][l] = rad * R.growth + R.tiny;
            }
        }
    }
    if (y.k) cut(y, half);
}

static ball derive_polynomial(const ball *taylor, integer terms, ball step, int order) {
    ball total = exact(0);
    for (integer k = order; k < terms; k++) {
        double factor = 1;
        for (int n = 0; n < order; n++) factor *= k - n;
        total = sum(total, product(product(exact(factor), taylor[k]), power(step, k - order)));
    }
    return total;
}

static void apply(jet of, jet x, integer code, integer n, const double *numbers) {
    LANES {
        ball v[2] = {at(x, 0, l), at(x, 1, l)}, y[2], first[2], second;
        if (code == POLYNOMIAL) {   /* about the centre of the lane, where powers of the difference are small */
            ball taylor[MOST_TERMS], about[MOST_TERMS], centre = exact(v[0].mid);
            for (integer k = 0; k < n; k++) about[k] = exact(numbers[k]);
            for (integer end = n; end > 1; end--)
                for (integer k = 1; k < end; k++) about[k] = sum(about[k], product(centre, about[k - 1]));
            for (integer k = 0; k < n; k++) taylor[k] = about[n - 1 - k];
            ball step[2] = {sum(v[0], negative(centre)), sum(v[1], negative(centre))};
            for (int p = 0; p < 2; p++) {
                y[p] = derive_polynomial(taylor, n, step[p], 0);
                first[p] = derive_polynomial(taylor, n, step[p], 1);
            }
            second = derive_polynomial(taylor, n, step[1], 2);
        } else if (code == POWER) {
            for (int p = 0; p < 2; p++) y[p] = power(v[p], n), first[p] = product(exact(n), power(v[p], n - 1));
            second = product(exact(n * (n - 1)), power(v[1], n > 2 ? n - 2 : 0));
        } else if (code == INVERSE) {
            for (int p = 0; p < 2; p++) y[p] = inverse(v[p]), first[p] = negative(product(y[p], y[p]));
            second = product(product(exact(2), product(y[1], y[1])), y[1]);
        } else if (code == SQRT) {
            for (int p = 0; p < 2; p++) y[p] = root(v[p]), first[p] = inverse(product(exact(2), y[p]));
            second = negative(product(first[1], inverse(product(exact(2), v[1]))));
        } else if (code == SIN) {
            for (int p = 0; p < 2; p++) y[p] = sine(v[p]), first[p] = cosine(v[p]);
            second = negative(y[1]);
        } else if (code == COS) {
            for (int p = 0; p < 2; p++) y[p] = cosine(v[p]), first[p] = negative(sine(v[p]));
            second = negative(y[1]);
        } else if (code == ARCTAN) {
            for (int p = 0; p < 2; p++) y[p] = arc(v[p]), first[p] = inverse(sum(exact(1), nonnegative(power(v[p], 2))));
            second = negative(product(product(product(exact(2), v[1]), first[1]), first[1]));
        } else if (code == EXP) {
            for (int p = 0; p < 2; p++) y[p] = first[p] = exponential(v[p]);
            second = y[1];
        } else {
            for (int p = 0; p < 2; p++) y[p] = logarithm(v[p]), first[p] = inverse(v[p]);
            second = negative(product(first[1], first[1]));
        }
        for (int p = 0; p < 2; p++) put(of, p, l, y[p]), put(of, 2 + p, l, first[p]);
        put(of, 4, l, second);
    }
}

static void fill(jet y, ball value) {
    for (int part = 0; part < 2; part++) LANES put(y, part, l, value);
}

static void choose(jet y, const double *condition, jet a, jet b, const integer *ia, const integer *ib) {
    for (integer row = 0; row < rows(y.k); row++) {
        integer p = row, q = row;
        if (row >= 2 && row < 2 + 2 * y.k) {
            int part = row >= 2 + y.k;
            p = place_gradient(a, ia, part, row - 2 - part * y.k), q = place_gradient(b, ib, part, row - 2 - part * y.k);
        } else if (row >= 2) {
            integer i = 0, left = row - 2 - 2 * y.k;
            while (left > i) left -= ++i;
            p = place_hessian(a, ia, i, left), q = place_hessian(b, ib, i, left);
        }
        LANES {
            ball x = p < 0 ? exact(0) : at(a, p, l), z = q < 0 ? exact(0) : at(b, q, l);
            put(y, row, l, condition[l] ? x : z);
        }
    }
}

/* The angle of a point: that of a fixed direction near it, and the angle from there; NaN where it may jump. */
static void take_angle(jet y, jet ordinate, jet abscissa, jet *t, const integer *io, const integer *ia, const integer *same,
                       const lane *half) {
    jet cosine_of = {0, t[0].mid, t[0].rad, 0}, sine_of = {0, t[1].mid, t[1].rad, 0}, fixed = {0, t[2].mid, t[2].rad, 0};
    jet radial = {y.k, t[3].mid, t[3].rad, y.support}, tangential = {y.k, t[4].mid, t[4].rad, y.support};
    jet part = {y.k, t[5].mid, t[5].rad, y.support}, other = {abscissa.k, t[5].mid, t[5].rad, 0};
    jet some = {ordinate.k, y.mid, y.rad, 0};
    LANES {
        double angle = atan2(ordinate.mid[0][l], abscissa.mid[0][l]), c = cos(angle), s = sin(angle);
        ball o = at(ordinate, 1, l), a = at(abscissa, 1, l);
        int apart = low(a) > 0 || low(o) > 0 || high(o) < 0;
        for (int p = 0; p < 2; p++) {
            put(cosine_of, p, l, exact(c)), put(sine_of, p, l, exact(s));
            put(fixed, p, l, (ball){apart ? atan2(s, c) : NAN, 2 * R.libm});
        }
    }
    multiply(some, ordinate, sine_of, same, none, half);
    multiply(other, abscissa, cosine_of, same, none, half);
    add(radial, other, some, ia, io, half);
    negate(sine_of, sine_of);
    multiply(some, ordinate, cosine_of, same, none, half);
    multiply(other, abscissa, sine_of, same, none, half);
    add(tangential, some, other, io, ia, half);
    apply(t[0], radial, INVERSE, 0, 0);
    chain(part, radial, t[0], half);
    multiply(y, tangential, part, same, same, half);
    apply(t[0], y, ARCTAN, 0, 0);
    chain(part, y, t[0], half);
    add(y, part, fixed, same, none, half);
}

typedef struct {
    const double *half, *script;
    const double *const *input_mid, *const *input_rad;
    double *const *output_mid, *const *output_rad;
    double *largest, *smallest, *answers;
    const integer *strides;   /* 0 for an input that is the same in all lanes, last that of half */
    integer lanes, script_rows, cutting;   /* whether jets are intersected with their Taylor forms */
} call;

static void load(jet y, const call *c, integer input, integer start) {
    integer stride = c->strides[input], width = stride ? c->lanes : 1;
    for (integer row = 0; row < rows(y.k); row++) LANES {
        integer place = row * width + (stride ? (start + l < c->lanes ? start + l : c->lanes - 1) : 0);
        y.mid[row][l] = c->input_mid[input][place];
        y.rad[row][l] = c->input_rad[input][place];
    }
}

static void answer(const call *c, integer question, integer start, const double *most, const double *least,
                   const double *usual, double *result) {
    LANES {
        integer place = start + l;
        int inside = place < c->lanes;
        double given = inside && question < c->script_rows ? c->script[question * c->lanes + place] : NAN;
        result[l] = isnan(given) ? (most[l] != least[l] ? usual[l] : least[l]) : given;
        if (inside) {
            c->largest[question * c->lanes + place] = most[l];
            c->smallest[question * c->lanes + place] = least[l];
            c->answers[question * c->lanes + place] = result[l];
        }
    }
}

static void run_block(const program *p, const call *c, integer start, lane *memory, lane *conditions, const lane *half) {
    integer question = 0, slot = 2 * p->rows;
    jet t[TEMPORARIES];
    for (int n = 0; n < TEMPORARIES; n++) {
        lane *place = memory + (p->registers + n) * slot;
        t[n] = (jet){0, place, place + p->rows, 0};
    }
    for (integer n = 0; n < p->operations; n++) {
        const integer *op = p->code + n * WIDTH, *table = p->tables + op[5], code = op[0];
        lane most, least, usual;
        if (code == OR) { LANES conditions[op[1]][l] = conditions[op[2]][l] != 0 || conditions[op[3]][l] != 0; continue; }
        if (code == AND) { LANES conditions[op[1]][l] = conditions[op[2]][l] != 0 && conditions[op[3]][l] != 0; continue; }
        if (code == NOT) { LANES conditions[op[1]][l] = conditions[op[2]][l] == 0; continue; }
        lane *ma = memory + op[2] * slot, *mb = memory + op[3] * slot, *my = memory + op[1] * slot;
        jet y = {table[0], my, my + p->rows, table + 3};
        jet a = {table[1], ma, ma + p->rows, 0}, b = {table[2], mb, mb + p->rows, 0};
        const integer *ia = table + 3 + y.k, *ib = ia + y.k, *same = ib + y.k;
        switch (code) {
        case INPUT: load(y, c, op[4], start); break;
        case CONSTANT: fill(y, exact(p->numbers[op[6]])); break;
        case PI: fill(y, (ball){R.pi, 2 * R.u}); break;
        case ADD: add(y, a, b, ia, ib, half); break;
        case MULTIPLY: multiply(y, a, b, ia, ib, half); break;
        case NEGATE: negate(y, a); break;
        case SELECT: choose(y, conditions[op[4]], a, b, ia, ib); break;
        case ARCTAN2: take_angle(y, a, b, t, ia, ib, same, half); break;
        case FLOOR:
            LANES {
                double up = floor(high(at(a, 1, l))), down = floor(low(at(a, 1, l))), mid = floor(a.mid[1][l]);
                most[l] = isnan(up) ? 0 : up, least[l] = isnan(down) ? 0 : down, usual[l] = isnan(mid) ? 0 : mid;
            }
            answer(c, question++, start, most, least, usual, usual);
            LANES put(y, 0, l, exact(usual[l])), put(y, 1, l, exact(usual[l]));
            break;
        case BELOW:
            LANES {
                ball x = at(a, 1, l);
                most[l] = op[4] ? low(x) < 0 : low(x) <= 0;
                least[l] = op[4] ? high(x) < 0 : high(x) <= 0;
                usual[l] = x.mid < 0;
            }
            answer(c, question++, start, most, least, usual, conditions[op[1]]);
            break;
        default:
            apply(t[0], a, code, op[4], p->numbers + op[6]);
            chain(y, a, t[0], half);
        }
    }
    for (integer n = 0; n < p->outputs; n++) {
        lane *place = memory + p->results[2 * n] * slot;
        integer count = rows(p->results[2 * n + 1]);
        for (integer row = 0; row < count; row++)
            for (int l = 0; l < BLOCK && start + l < c->lanes; l++) {
                c->output_mid[n][row * c->lanes + start + l] = place[row][l];
                c->output_rad[n][row * c->lanes + start + l] = place[p->rows + row][l];
            }
    }
}

/* Run a program on all lanes. Returns 0, or 1 if there is no memory. */
integer run(const program *p, const call *c, const rounding *r) {
    R = *r;
    cutting = c->cutting;
    for (int n = 0; n < MOST_PARAMETERS; n++) none[n] = -1;
    size_t count = (size_t)(p->registers + TEMPORARIES) * 2 * p->rows + p->conditions + p->parameters + 1;
    lane *memory = malloc(count * sizeof(lane));
    if (!memory) return 1;
    lane *conditions = memory + (p->registers + TEMPORARIES) * 2 * p->rows, *half = conditions + p->conditions;
    integer stride = c->strides[p->inputs];
    for (integer start = 0; start < c->lanes; start += BLOCK) {
        for (integer i = 0; i < p->parameters; i++) LANES {
            integer place = start + l < c->lanes ? start + l : c->lanes - 1;
            half[i][l] = c->half[i * (stride ? c->lanes : 1) + (stride ? place : 0)];
        }
        run_block(p, c, start, memory, conditions, half);
    }
    free(memory);
    return 0;
}
