// A baked pack, played without a server: its blows and one-shots happen again as in the bake, and the levels are printed frame by frame.
//     mcs -out:alone.exe -r:System.Net.Http HapticTracing.cs HapticPack.cs Alone.cs && mono alone.exe SCENE.pack.json 24

using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using HapticTracing;

static class Alone
{
    static void Main(string[] arguments)
    {
        var pack = new Pack(File.ReadAllText(arguments[0]));
        var rate = double.Parse(arguments[1], CultureInfo.InvariantCulture);
        var frames = arguments.Length > 2 ? int.Parse(arguments[2]) : 100;
        foreach (var limit in pack.Limits) Console.Error.WriteLine(limit);
        for (var frame = 1; frame <= frames; frame++)
        {
            // Here a game would call Hit from its physics, and Play from its rules.
            foreach (var blow in pack.Blows)
                if (blow.Time >= (frame - 1) / rate && blow.Time < frame / rate) pack.Hit(blow.First, blow.Second, blow.Energy, blow.Position, blow.Time);
            foreach (var shot in pack.Shots)
                if (shot.Value >= (frame - 1) / rate && shot.Value < frame / rate) pack.Play(shot.Key, shot.Value);
            pack.Advance(frame / rate);
            var levels = new List<string>();
            foreach (var listener in pack.Listeners)
                levels.Add(listener + "=" + pack.LevelAt(listener).Decibels.ToString("0.0000", CultureInfo.InvariantCulture));
            Console.WriteLine(frame + " " + string.Join(" ", levels));
        }
    }
}
