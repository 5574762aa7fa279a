// A scene without a file: a tone runs from a bench over its foot into the ground, until these part; a blow; what is removed falls silent.

using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using HapticTracer;

static class MadeInCode
{
    static void Main()
    {
        var tracer = new Tracer();
        var bench = new TracedObject { Name = "bench", Function = new Function(0, 0.3), Mass = 4 };
        var ground = new TracedObject { Name = "ground", Function = Function.Paper(0.5, 0.8) };
        tracer.Objects.AddRange(new[] { bench, ground });
        bench.Move(0, 1, 0, 1, 0, 0, 0);
        var tone = new Source { On = bench, Position = new Vector(0, 1, 0), Amplitude = 0.5, Signal = Signal.Tone(80) };
        tracer.Sources.Add(tone);
        tracer.Listeners.Add(new Listener { On = ground, Position = new Vector(3, 0, 0), Radius = 0.5 });
        var contact = tracer.Touch(bench, ground);
        Run(tracer, 50);
        Say(tone.Gain(0), tracer.Level(0), tone.Paths[0].Count);
        tracer.Part(contact);
        Run(tracer, 50);
        Say(tone.Gain(0), tracer.Level(0), tone.Paths[0].Count);
        tracer.Blow(bench, ground, new Vector(0, 0, 0), Tracer.Energy(bench, ground, 5));
        Run(tracer, 1);
        Say(tracer.Blows[0].Amplitude, tracer.Blows[0].Gain(0), tracer.Level(0));
        tracer.Remove(bench);
        Run(tracer, 50);
        Say(tracer.Objects.Count, tracer.Sources.Count + tracer.Blows.Count, tracer.Level(0));
    }

    static void Run(Tracer tracer, int steps) { for (var step = 0; step < steps; step++) tracer.Step(0.02); }

    static void Say(params double[] values)
    {
        Console.WriteLine(string.Join(" ", values.Select(value => value.ToString("R", CultureInfo.InvariantCulture))));
    }
}
