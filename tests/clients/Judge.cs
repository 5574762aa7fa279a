// Plays a script of steps to the tracer and prints what comes back, a line of JSON for each step.
//     mcs -out:judge.exe HapticTracer.cs Judge.cs && mono judge.exe < script

using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Linq;
using HapticTracer;

static class Judge
{
    static void Main()
    {
        Tracer tracer = null;
        var contacts = new List<Contact>();
        for (string line; (line = Console.ReadLine()) != null;)
        {
            var words = line.Split(' ');
            if (words[0] == "read")
            {
                tracer = Tracer.Read(File.ReadAllText(line.Substring(5)));
                contacts.Clear();
                continue;
            }
            var n = words.Skip(1).Select(word => double.Parse(word, CultureInfo.InvariantCulture)).ToArray();
            int first = n.Length > 0 ? (int)n[0] : 0, second = n.Length > 1 ? (int)n[1] : 0;
            switch (words[0])
            {
                case "move": tracer.Objects[first].Move(n[1], n[2], n[3], n[4], n[5], n[6], n[7]); break;
                case "touch":
                    var contact = tracer.Touch(tracer.Objects[first], tracer.Objects[second]);
                    if (contact == null) break;
                    contacts.Add(contact);
                    contact.At = At(n, 2);
                    contact.OtherAt = At(n, 5);
                    contact.Normal = At(n, 8);
                    contact.Area = n[11];
                    contact.Force = n[12];
                    contact.Depth = n[13];
                    contact.Weight = n[14];
                    break;
                case "part":
                    contacts.ForEach(tracer.Part);
                    contacts.Clear();
                    break;
                case "amplitude": tracer.Sources[first].Amplitude = n[1]; break;
                case "source": tracer.Sources[first].Position = tracer.Sources[first].On.ToLocal(At(n, 1)); break;
                case "listener": tracer.Listeners[first].Position = tracer.Listeners[first].On.ToLocal(At(n, 1)); break;
                case "play": tracer.Play(tracer.Sources[first]); break;
                case "blow": tracer.Blow(tracer.Objects[first], tracer.Objects[second], At(n, 2), n[5], n[6]); break;
                case "step":
                    tracer.Step(n[0]);
                    Console.WriteLine(Answer(tracer));
                    break;
            }
        }
    }

    static Vector At(double[] numbers, int place) { return new Vector(numbers[place], numbers[place + 1], numbers[place + 2]); }

    static string Answer(Tracer tracer)
    {
        var listeners = Enumerable.Range(0, tracer.Listeners.Count).ToArray();
        var levels = listeners.Select(l => Text(tracer.Level(l)));
        return "{\"levels\":" + Row(levels) + ",\"count\":" + tracer.Count
            + ",\"sources\":" + Row(tracer.Sources.Select(source => Heard(tracer, source, listeners)))
            + ",\"blows\":" + Row(tracer.Blows.Select(source => Heard(tracer, source, listeners))) + "}";
    }

    static string Heard(Tracer tracer, Source source, int[] listeners)
    {
        return "{\"amplitude\":" + Text(source.Amplitude) + ",\"gains\":" + Row(listeners.Select(l => Text(source.Gain(l))))
            + ",\"delays\":" + Row(source.Later.Select(Text)) + ",\"lanes\":" + Row(source.Gains.Select(Text)) + ",\"paths\":" + Row(source.Paths.Select(path => Row(path.Select(item => tracer.Objects.IndexOf(item).ToString())))) + "}";
    }

    static string Row(IEnumerable<string> parts) { return "[" + string.Join(",", parts) + "]"; }

    static string Text(double value) { return double.IsNaN(value) ? "null" : value.ToString("R", CultureInfo.InvariantCulture); }
}
