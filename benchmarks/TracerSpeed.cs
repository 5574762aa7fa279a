// The time of a step of the tracer: the file of its tables, and the contacts, a line of numbers each, of standard input.

using System;
using System.Diagnostics;
using System.Globalization;
using System.IO;
using System.Linq;
using HapticTracer;

static class TracerSpeed
{
    const int Warm = 100, Steps = 400;

    static void Main(string[] arguments)
    {
        var tracer = Tracer.Read(File.ReadAllText(arguments[0]));
        var rows = Console.In.ReadToEnd().Split(new[] { '\n' }, StringSplitOptions.RemoveEmptyEntries)
            .Select(line => line.Split(' ').Select(word => double.Parse(word, CultureInfo.InvariantCulture)).ToArray()).ToArray();
        var contacts = rows.Select(n => tracer.Touch(tracer.Objects[(int)n[0]], tracer.Objects[(int)n[1]])).ToArray();
        for (var k = 0; k < rows.Length; k++)
        {
            contacts[k].Normal = new Vector(rows[k][5], rows[k][6], rows[k][7]);
            contacts[k].Area = rows[k][8];
        }
        var times = new double[Steps];
        var watch = new Stopwatch();
        var collections = 0;
        var processor = TimeSpan.Zero;
        for (var step = -Warm; step < Steps; step++)
        {
            if (step == 0)
            {
                collections = GC.CollectionCount(0);
                processor = Process.GetCurrentProcess().TotalProcessorTime;
            }
            watch.Restart();
            for (var k = 0; k < rows.Length; k++) contacts[k].At = contacts[k].OtherAt = new Vector(rows[k][2], rows[k][3], rows[k][4] + 1e-4 * (step & 7));
            tracer.Step(1 / 60.0);
            for (var l = 0; l < tracer.Listeners.Count; l++) tracer.Level(l);
            if (step >= 0) times[step] = watch.Elapsed.TotalMilliseconds;
        }
        processor = Process.GetCurrentProcess().TotalProcessorTime - processor;
        collections = GC.CollectionCount(0) - collections;
        var heard = tracer.Sources.Sum(source => source.Paths.Count(path => path.Count > 0));
        Array.Sort(times);
        Console.WriteLine(FormattableString.Invariant($"{tracer.Objects.Count} {contacts.Length} {heard} {times[0]:0.000} {times[Steps / 2]:0.000} {processor.TotalMilliseconds / Steps:0.000} {collections}"));
    }
}
