// A crate falls onto the ground: the sample of the C# client, without an engine.
//     mcs -out:fall.exe -r:System.Net.Http HapticTracing.cs Fall.cs && mono fall.exe ws://127.0.0.1:7710

using System;
using System.Collections.Generic;
using System.Threading;
using HapticTracing;

static class Fall
{
    static int Main(string[] arguments)
    {
        int blows = 0, frames = 0;
        double last = double.NaN;
        string fault = null;
        using (var client = Connected(arguments[0]))
        {
            client.Levels += levels => { frames++; last = levels["hand"].Decibels; };
            client.Impacted += impact =>
            {
                blows++;
                Console.WriteLine(FormattableString.Invariant($"{impact.First} and {impact.Second}: {impact.Energy:0.0} J at {impact.Time:0.000} s"));
            };
            client.Failed += (where, message) => fault = where + ": " + message;
            for (var waited = 0; !client.IsConnected && fault == null && waited < 1000; waited++)
            {
                Thread.Sleep(10);
                client.Update();
            }
            for (var frame = 0; frame < 90 && fault == null; frame++)
            {
                var time = frame / 60.0;
                client.Move("crate", 0, Math.Max(1.5 - 9.81 / 2 * time * time, 0) + 0.5, 0, 1, 0, 0, 0);
                client.Step(time);
                for (var seen = frames; frames == seen && fault == null;)
                {
                    Thread.Sleep(1);
                    client.Update();
                }
            }
            // A moon is not in the scene: the server says so, and the connection stays.
            client.Move("moon", 0, 0, 0, 1, 0, 0, 0);
            client.Step(2);
            for (var waited = 0; fault == null && waited < 1000; waited++)
            {
                Thread.Sleep(10);
                client.Update();
            }
        }
        Console.WriteLine(FormattableString.Invariant($"{frames} frames, {blows} blows, hand at {last:0.00} dB, then: {fault}"));
        return blows == 1 ? 0 : 1;
    }

    /// <summary>A client of a server that may still be starting: half a minute is waited for it.</summary>
    static Client Connected(string url)
    {
        for (var tries = 0; ; tries++)
        {
            var client = new Client();
            try
            {
                client.ConnectAsync(url, new Dictionary<string, object> { { "up", "y" }, { "handedness", "left" } }).Wait();
                return client;
            }
            catch (AggregateException) when (tries < 60)
            {
                client.Dispose();
                Thread.Sleep(500);
            }
        }
    }
}
