/* Loads the library of an FMU and steps it, in a process that has nothing of Python.
 *
 *     host LIBRARY GUID STEP REPEATS INPUTS OUTPUTS PARAMETERS
 *
 * INPUTS, OUTPUTS: values such as r3,i0,b2: a column and a place in it. PARAMETERS: r3=1.5,s0=a,…
 * Standard input: doubles, a row of the inputs for each step. Standard output: doubles, the outputs
 * after initialization and after each step. The rows are then stepped REPEATS times more, each
 * with all its inputs set and all its outputs read, and what that took is told on standard error.
 */
#define _POSIX_C_SOURCE 200112L
#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Calls;

typedef struct {
    unsigned int refs[256];
    double values[256];
    int places[256], n;
} Part;

typedef struct {
    Part real, integer, boolean, text;
    const char *texts[256];
    int n;
} Values;

static size_t allocated = 0;
static void *library;

static void logger(void *environment, const char *name, int status, const char *category, const char *text, ...)
{
    va_list more;

    (void)environment;
    fprintf(stderr, "%s %s %d: ", name, category, status);
    va_start(more, text);
    vfprintf(stderr, text, more);
    va_end(more);
    fprintf(stderr, "\n");
}

static void *allocate(size_t n, size_t size)
{
    allocated += n * size;
    return calloc(n, size);
}

typedef void (*Function)(void);

/* POSIX has a function fit into a void pointer, which C by itself does not say. */
static Function symbol(const char *name)
{
    void *found = dlsym(library, name);
    Function function;

    if (found == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        exit(3);
    }
    memcpy(&function, &found, sizeof function);
    return function;
}

typedef void *(*Instantiate)(const char *, int, const char *, const char *, const Calls *, int, int);
typedef int (*Setup)(void *, int, double, double, int, double);
typedef int (*Plain)(void *);
typedef void (*Free)(void *);
typedef int (*DoStep)(void *, double, double, int);
typedef int (*Reals)(void *, const unsigned int *, size_t, double *);
typedef int (*Strings)(void *, const unsigned int *, size_t, const char **);
typedef int (*Integers)(void *, const unsigned int *, size_t, int *);

static Reals get_real, set_real;
static Integers get_integer, set_integer, get_boolean, set_boolean;

static void checked(int status, const char *what)
{
    if (status > 1) {
        fprintf(stderr, "%s ended with %d\n", what, status);
        exit(4);
    }
}

static void parsed(char *text, Values *out)
{
    char *word;

    memset(out, 0, sizeof *out);
    for (word = strtok(text, ","); word != NULL; word = strtok(NULL, ",")) {
        Part *part = word[0] == 'r'   ? &out->real
                     : word[0] == 'i' ? &out->integer
                     : word[0] == 'b' ? &out->boolean
                                      : &out->text;
        char *value = strchr(word, '=');

        if (part == &out->text && value != NULL)
            out->texts[part->n] = value + 1;
        part->values[part->n] = value != NULL ? atof(value + 1) : 0.0;
        part->places[part->n] = out->n++;
        part->refs[part->n++] = (unsigned int)atoi(word + 1);
    }
}

static void set_whole(Integers set, void *c, const Part *part)
{
    int whole[256], i;

    for (i = 0; i < part->n; i++)
        whole[i] = (int)part->values[i];
    checked(set(c, part->refs, (size_t)part->n, whole), "setting");
}

static void set_all(void *c, Values *values)
{
    checked(set_real(c, values->real.refs, (size_t)values->real.n, values->real.values), "setting");
    set_whole(set_integer, c, &values->integer);
    set_whole(set_boolean, c, &values->boolean);
}

static void take(Part *part, const double *row)
{
    int i;

    for (i = 0; i < part->n; i++)
        part->values[i] = row[part->places[i]];
}

static void set_row(void *c, Values *values, const double *row)
{
    take(&values->real, row);
    take(&values->integer, row);
    take(&values->boolean, row);
    set_all(c, values);
}

static void get_row(void *c, Values *values, double *row)
{
    int whole[256], i;

    checked(get_real(c, values->real.refs, (size_t)values->real.n, values->real.values), "reading");
    for (i = 0; i < values->real.n; i++)
        row[values->real.places[i]] = values->real.values[i];
    checked(get_integer(c, values->integer.refs, (size_t)values->integer.n, whole), "reading");
    for (i = 0; i < values->integer.n; i++)
        row[values->integer.places[i]] = whole[i];
    checked(get_boolean(c, values->boolean.refs, (size_t)values->boolean.n, whole), "reading");
    for (i = 0; i < values->boolean.n; i++)
        row[values->boolean.places[i]] = whole[i];
}

/* Seconds of the processor for this process: others at work beside it do not count. */
static double now(void)
{
    struct timespec t;

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* KiB that this process has had in memory at most; that of a process before it does not count. */
static long peak(void)
{
    char line[256];
    long found = 0;
    FILE *file = fopen("/proc/self/status", "r");

    if (file == NULL)
        return 0;
    while (fgets(line, sizeof line, file) != NULL)
        if (sscanf(line, "VmHWM: %ld", &found) == 1)
            break;
    fclose(file);
    return found;
}

int main(int count, char **words)
{
    static Values inputs, outputs, parameters;
    Calls calls = {logger, allocate, free, NULL, NULL};
    double *rows = NULL, out[256], step, start, seconds;
    size_t n = 0, width;
    long repeats, i;
    DoStep do_step;
    void *c;

    if (count != 8)
        return 2;
    library = dlopen(words[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 3;
    }
    step = atof(words[3]);
    repeats = atol(words[4]);
    parsed(words[5], &inputs);
    parsed(words[6], &outputs);
    parsed(words[7], &parameters);
    get_real = (Reals)symbol("fmi2GetReal");
    set_real = (Reals)symbol("fmi2SetReal");
    get_integer = (Integers)symbol("fmi2GetInteger");
    set_integer = (Integers)symbol("fmi2SetInteger");
    get_boolean = (Integers)symbol("fmi2GetBoolean");
    set_boolean = (Integers)symbol("fmi2SetBoolean");
    do_step = (DoStep)symbol("fmi2DoStep");
    width = (size_t)inputs.n;
    if (width > 0) {
        size_t room = 1024;

        rows = malloc(room * width * sizeof *rows);
        while (rows != NULL && fread(rows + n * width, sizeof *rows, width, stdin) == width)
            if (++n == room)
                rows = realloc(rows, (room *= 2) * width * sizeof *rows);
    }
    if (rows == NULL)
        return 2;
    c = ((Instantiate)symbol("fmi2Instantiate"))("tried", 1, words[2], "", &calls, 0, 1);
    if (c == NULL)
        return 4;
    checked(((Setup)symbol("fmi2SetupExperiment"))(c, 0, 0.0, 0.0, 0, 0.0), "the experiment");
    set_all(c, &parameters);
    checked(((Strings)symbol("fmi2SetString"))(c, parameters.text.refs, (size_t)parameters.text.n,
                                               parameters.texts),
            "setting");
    checked(((Plain)symbol("fmi2EnterInitializationMode"))(c), "the begin");
    checked(((Plain)symbol("fmi2ExitInitializationMode"))(c), "the begin");
    get_row(c, &outputs, out);
    fwrite(out, sizeof *out, (size_t)outputs.n, stdout);
    for (i = 0; i < (long)n; i++) {
        set_row(c, &inputs, rows + (size_t)i * width);
        checked(do_step(c, (double)i * step, step, 1), "a step");
        get_row(c, &outputs, out);
        fwrite(out, sizeof *out, (size_t)outputs.n, stdout);
    }
    start = now();
    for (i = 0; i < repeats; i++) {
        set_row(c, &inputs, rows + (size_t)i % n * width);
        checked(do_step(c, (double)((long)n + i) * step, step, 1), "a step");
        get_row(c, &outputs, out);
    }
    seconds = now() - start;
    ((Plain)symbol("fmi2Terminate"))(c);
    ((Free)symbol("fmi2FreeInstance"))(c);
    dlclose(library);
    free(rows);
    if (repeats > 0)
        fprintf(stderr, "%g %g %zu %ld\n", (double)repeats / seconds, seconds / (double)repeats * 1e9,
                allocated, peak());
    return 0;
}
